// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/frames/frame_text.h"

#include <algorithm>
#include <array>

#include "host_tests/lab/frames/hex.h"
#include "host_tests/lab/input_error.h"
#include "protocol/aes256.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::lab {
namespace {

class LineReader {
 public:
  LineReader(const Json& line, const LineOrigin& origin) : line_(line), origin_(origin) {}

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw InputError(origin_.file, origin_.line, key, what);
  }

  bool has(const std::string& key) const { return line_.contains(key) && !line_[key].is_null(); }

  unsigned number(const std::string& key, unsigned highest) const {
    if (!has(key) || !line_[key].is_number_integer()) {
      fail(key, "must be a whole number");
    }
    const auto value = line_[key].get<long long>();
    if (value < 0 || value > static_cast<long long>(highest)) {
      fail(key, "must be 0 to " + std::to_string(highest));
    }
    return static_cast<unsigned>(value);
  }

  bool flag(const std::string& key) const {
    if (!has(key) || !line_[key].is_boolean()) {
      fail(key, "must be true or false");
    }
    return line_[key].get<bool>();
  }

  std::string text(const std::string& key) const {
    if (!has(key) || !line_[key].is_string()) {
      fail(key, "must be a text");
    }
    return line_[key].get<std::string>();
  }

  std::vector<std::byte> bytes(const std::string& key) const {
    const auto bytes = from_hex(text(key));
    if (!bytes) {
      fail(key, "must be pairs of hexadecimal digits");
    }
    return *bytes;
  }

 private:
  const Json& line_;
  const LineOrigin& origin_;
};

std::optional<protocol::MessageId> read_id(const LineReader& reader) {
  if (!reader.has("cmd_set") && !reader.has("cmd_id")) {
    return std::nullopt;
  }
  return protocol::MessageId{static_cast<std::uint8_t>(reader.number("cmd_set", 255)),
                             static_cast<std::uint8_t>(reader.number("cmd_id", 255))};
}

std::string explain(core::Status status) {
  return status == core::Status::kInvalidArgument
             ? "an acknowledgement carries no cmd_set, and an encrypted frame needs data"
         : status == core::Status::kOutOfRange  ? "longer than a frame can be"
         : status == core::Status::kUnavailable ? "an encrypted frame needs its key_hex (or --key-file)"
                                                : std::string(core::name(status));
}

}  // namespace

protocol::CipherKey parse_key(const std::string& hex, const LineOrigin& origin, const std::string& key_name) {
  const auto bytes = from_hex(hex);
  protocol::CipherKey key{};
  if (!bytes || bytes->size() != key.size()) {
    throw InputError(origin.file, origin.line, key_name, "a key is 64 hexadecimal digits");
  }
  std::transform(bytes->begin(), bytes->end(), key.begin(),
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  return key;
}

std::vector<std::byte> frame_from_line(const Json& line, const LineOrigin& origin,
                                       const std::optional<protocol::CipherKey>& key) {
  const LineReader reader(line, origin);
  const protocol::Envelope envelope{.session = static_cast<std::uint8_t>(reader.number("session", 31)),
                                    .is_ack = reader.flag("is_ack"),
                                    .encrypted = reader.flag("encrypted"),
                                    .sequence = static_cast<std::uint16_t>(reader.number("seq", 65535))};
  const std::optional<protocol::MessageId> id = read_id(reader);
  const std::vector<std::byte> value = reader.bytes("payload_hex");
  std::optional<protocol::Aes256> cipher;
  std::vector<std::byte> filler;
  if (envelope.encrypted) {
    if (reader.has("key_hex")) {
      cipher.emplace(parse_key(reader.text("key_hex"), origin, "key_hex"));
    } else if (key) {
      cipher.emplace(*key);
    }
    if (reader.has("padding_hex")) {
      filler = reader.bytes("padding_hex");
    }
  }
  std::array<std::byte, protocol::kMaxFrameBytes> space;
  const auto frame = encode_frame(envelope, id ? &*id : nullptr, value, space, cipher ? &*cipher : nullptr, filler);
  if (!frame) {
    reader.fail(frame.status() == core::Status::kUnavailable ? "key_hex" : "payload_hex", explain(frame.status()));
  }
  const std::size_t data_bytes = value.size() + (id ? protocol::kMessageIdBytes : 0);
  const std::size_t padding = frame->size() - protocol::kFrameOverheadBytes - data_bytes;
  if (envelope.encrypted && !filler.empty() && filler.size() != padding) {
    reader.fail("padding_hex", "must have " + std::to_string(padding) + " bytes");
  }
  return {frame->begin(), frame->end()};
}

}  // namespace m100::lab
