// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/fuzz/receive.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "host_tests/property/protocol/reference_parser.h"
#include "protocol/crc.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/pushes.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"

namespace m100::host_tests {
namespace {

using namespace protocol;

void require(bool holds) {
  if (!holds) {
    __builtin_trap();
  }
}

/// Not a real cipher, but invertible: the fuzzer tests our code, not mbedTLS.
class Scrambler final : public Cipher {
 public:
  void encrypt(CipherBlock block) const override { std::transform(block.begin(), block.end(), block.begin(), turn); }
  void decrypt(CipherBlock block) const override { encrypt(block); }

 private:
  static std::byte turn(std::byte value) { return value ^ std::byte{0x5A}; }
};

const Scrambler kScrambler;

bool same(std::span<const std::byte> a, std::span<const std::byte> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

/// A decoded command, encoded again, must either be refused by the encoder's limits or come back unchanged from another
/// round. Reserved bits and unknown codes are not kept, so the received bytes themselves are not compared.
void check_command(const Message& message) {
  const auto command = decode_command(message.id, message.value);
  if (!command) {
    return;
  }
  std::visit(
      [&](const auto& typed) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(typed)>, std::monostate>) {
          const auto value = encode(typed);
          if (!value) {
            return;
          }
          const auto again = decode_command(id_of(typed), *value);
          require(again.has_value());
          const auto* const same_type = std::get_if<std::decay_t<decltype(typed)>>(&*again);
          require(same_type != nullptr && same(encode(*same_type)->bytes(), value->bytes()));
        }
      },
      *command);
}

void check_telemetry(const Message& message) {
  Telemetry telemetry;
  if (decode_telemetry(message.value, telemetry) == core::Status::kOk) {
    require(same(encode(telemetry).bytes(), message.value));
  }
}

void check_answer(const Message& message) {
  if (const auto version = decode_version_answer(message.value); version) {
    (void)sdk_version(*version);
    require(message.value.size() != VersionAnswer::kBytes || same(encode(*version).bytes(), message.value));
  }
  if (const auto code = decode_ack(message.value); code) {
    for (const MessageInfo& info : kCatalogue) {
      require(!ack_meaning(info.id, *code).name.empty());
    }
  }
}

void check_frame_is_made_again(const FrameView& frame, const Message& message) {
  const bool canonical =
      !frame.header.encrypted()
          ? frame.header.padding_bytes == 0 && (frame.data.size() > 0 || frame.bytes.size() == kHeaderBytes)
          : frame.header.encryption == 1 && frame.header.padding_bytes >= 1 && frame.header.padding_bytes <= 16 &&
                frame.data.size() > frame.header.padding_bytes;
  if (!canonical) {
    return;
  }
  std::array<std::byte, kMaxFrameBytes> space;
  const Envelope envelope{.session = frame.header.session,
                          .is_ack = frame.header.is_ack,
                          .encrypted = frame.header.encrypted(),
                          .sequence = frame.header.sequence};
  const auto again =
      encode_frame(envelope, message.has_id ? &message.id : nullptr, message.value, space, &kScrambler, message.filler);
  require(again.has_value() && same(*again, frame.bytes));
}

class Receiver {
 public:
  void take(const FrameView& frame) {
    CipherScratch scratch;
    if (frame.header.encrypted()) {
      require(open(frame, nullptr, scratch).status() == core::Status::kUnavailable);
    }
    const auto message = open(frame, &kScrambler, scratch);
    require(message.has_value());
    check_frame_is_made_again(frame, *message);
    if (message->header.is_ack) {
      check_answer(*message);
      (void)asking_.accept(*message, now_);
    } else {
      check_command(*message);
      (void)decode_push(message->id, message->value);
      check_telemetry(*message);
      serve(*message);
    }
    now_ += std::chrono::milliseconds(7);
    while (asking_.poll(now_)) {
    }
  }

 private:
  void serve(const Message& message) {
    const auto reception = answering_.accept(message.header);
    if (reception.verdict == AnswerSessions::Verdict::kExecute && message.header.session != kUnansweredSession) {
      require(answering_.answer(message.header, encode_ack(0), &kScrambler).has_value());
    }
    (void)asking_.request(message.id, message.value.first(std::min<std::size_t>(message.value.size(), 16)),
                          {.timeout = std::chrono::milliseconds(20), .transmissions = 2}, now_);
  }

  RequestSessions asking_;
  AnswerSessions answering_;
  core::TimePoint now_{};
};

}  // namespace

void receive_everything(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const std::size_t portion = 1 + std::to_integer<std::size_t>(input[0]) * 5;
  const Bytes stream(input.begin() + 1, input.end());
  const std::vector<FoundFrame> expected = slow_parse(stream);
  FrameParser parser;
  Receiver receiver;
  std::size_t found = 0;
  for (std::size_t at = 0; at < stream.size(); at += portion) {
    const auto bytes = std::span(stream).subspan(at, std::min(portion, stream.size() - at));
    parser.consume(bytes, [&](const FrameView& frame) {
      require(found < expected.size() && expected[found].offset == frame.offset);
      require(same(expected[found].bytes, frame.bytes));
      ++found;
      receiver.take(frame);
    });
  }
  require(found == expected.size());
  parser.abandon_candidate();
  while (parser.poll()) {
  }
}

void repair_frames(std::span<std::byte> bytes, std::uint64_t choice) {
  for (std::size_t at = bytes.size(); at-- > 0;) {
    if (bytes[at] != kStartByte || bytes.size() - at < kHeaderBytes) {
      continue;
    }
    const std::uint64_t what = choice & 3U;
    choice = (choice >> 2U) | (choice << 62U);
    if (what == 0) {
      continue;  // this frame stays broken
    }
    const auto frame = bytes.subspan(at);
    frame[2] &= std::byte{3};
    frame[3] &= std::byte{0x3F};
    frame[5] = frame[6] = frame[7] = std::byte{0};
    const std::uint16_t header_crc = crc16(frame.first(10));
    std::memcpy(&frame[10], &header_crc, sizeof(header_crc));
    const std::size_t length = load<std::uint16_t>(&frame[1]) & 0x3FFU;
    if (what > 1 && length >= kFrameOverheadBytes && length <= frame.size()) {
      const std::uint32_t frame_crc = crc32(frame.first(length - 4));
      std::memcpy(&frame[length - 4], &frame_crc, sizeof(frame_crc));
    }
  }
}

}  // namespace m100::host_tests
