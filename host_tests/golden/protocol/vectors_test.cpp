// SPDX-License-Identifier: BSD-3-Clause
// Golden vectors of the shared material, made by running DJI's own code (each line names its source): to_fc frames are
// what DJI's API calls put on the port, from_fc frames were accepted by DJI's parser. Bytes must agree exactly, decoded
// values to half a unit of the ninth digit that the file prints.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "host_tests/lab/frames/frame_text.h"
#include "host_tests/lab/frames/hex.h"
#include "host_tests/lab/frames/message_json.h"
#include "host_tests/shared_files.h"
#include "protocol/aes256.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/pushes.h"
#include "protocol/dji/telemetry.h"

namespace m100::lab {
namespace {

std::vector<Json> read_vectors(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Json> vectors;
  for (std::string line; std::getline(file, line);) {
    vectors.push_back(Json::parse(line));
  }
  return vectors;
}

/// Every value of `expected` must be in `actual`; numbers may differ by what nine printed digits of a float leave open.
void expect_same(const Json& expected, const Json& actual, const std::string& where) {
  if (expected.is_object()) {
    for (const auto& [key, value] : expected.items()) {
      ASSERT_TRUE(actual.contains(key)) << where << '.' << key;
      expect_same(value, actual[key], where + '.' + key);
    }
  } else if (expected.is_array()) {
    ASSERT_EQ(expected.size(), actual.size()) << where;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      expect_same(expected[i], actual[i], where + '[' + std::to_string(i) + ']');
    }
  } else if (expected.is_number_float()) {
    const auto value = expected.get<double>();
    const bool is_double = where.ends_with("lat_rad") || where.ends_with("lon_rad");
    EXPECT_NEAR(value, actual.get<double>(), is_double ? 0. : std::abs(value) * 6e-8) << where;
  } else {
    EXPECT_EQ(expected, actual) << where;
  }
}

std::vector<std::byte> hex_of(const Json& vector, const char* key) {
  return from_hex(vector.at(key).get<std::string>()).value();
}

std::optional<protocol::Aes256>& cipher_of(const Json& vector, std::optional<protocol::Aes256>& cipher) {
  if (!vector.at("key_hex").is_null()) {
    cipher.emplace(parse_key(vector.at("key_hex").get<std::string>(), {}, "key_hex"));
  }
  return cipher;
}

std::vector<Json> decode_all(std::span<const std::byte> bytes, const protocol::Cipher* cipher, CommandMemory& memory) {
  std::vector<Json> lines;
  protocol::FrameParser parser;
  parser.consume(bytes, [&](const protocol::FrameView& frame) { lines.push_back(frame_line(frame, cipher, memory)); });
  return lines;
}

/// The value bytes, encoded again from the typed message that the frame holds.
std::vector<std::byte> retyped_value(const protocol::Message& message,
                                     const std::optional<protocol::MessageId>& answered) {
  const auto copy = [](const protocol::Value& value) {
    return std::vector<std::byte>(value.bytes().begin(), value.bytes().end());
  };
  if (message.header.is_ack) {
    return answered == protocol::ids::kVersionQuery ? copy(encode(*protocol::decode_version_answer(message.value)))
                                                    : copy(protocol::encode_ack(*protocol::decode_ack(message.value)));
  }
  if (message.id == protocol::ids::kTelemetry) {
    protocol::Telemetry telemetry;
    EXPECT_EQ(decode_telemetry(message.value, telemetry), core::Status::kOk);
    return copy(encode(telemetry));
  }
  const auto encode_any = [&](const auto& typed) -> std::vector<std::byte> {
    if constexpr (!std::is_same_v<std::decay_t<decltype(typed)>, std::monostate>) {
      EXPECT_EQ(id_of(typed), message.id);
      return copy(*encode(typed));
    } else {
      return {};
    }
  };
  if (const auto command = protocol::decode_command(message.id, message.value); command) {
    return std::visit(encode_any, *command);
  }
  return std::visit(encode_any, *protocol::decode_push(message.id, message.value));
}

void check_accepted(const Json& vector) {
  std::optional<protocol::Aes256> cipher_space;
  const auto& cipher = cipher_of(vector, cipher_space);
  const protocol::Cipher* const key = cipher ? &*cipher : nullptr;
  CommandMemory memory;
  if (vector.contains("request_frame_hex")) {
    ASSERT_EQ(decode_all(hex_of(vector, "request_frame_hex"), key, memory).size(), 1U);
  }
  const std::vector<std::byte> wire = hex_of(vector, "frame_hex");
  const std::vector<Json> lines = decode_all(wire, key, memory);
  ASSERT_EQ(lines.size(), 1U);
  for (const char* same : {"session", "is_ack", "seq", "encrypted", "cmd_set", "cmd_id", "payload_hex", "fields",
                           "padding_hex", "ack_for"}) {
    if (vector.contains(same)) {
      ASSERT_TRUE(lines[0].contains(same)) << same;
      expect_same(vector[same], lines[0][same], same);
    }
  }
  EXPECT_EQ(to_hex(frame_from_line(vector, {"vectors.jsonl", 0}, std::nullopt)), to_hex(wire));

  protocol::FrameParser parser;
  ASSERT_EQ(parser.push(wire), wire.size());
  const auto frame = parser.poll();
  protocol::CipherScratch scratch;
  const auto message = open(*frame, key, scratch);
  EXPECT_EQ(to_hex(retyped_value(*message, memory.command_of(frame->header))), to_hex(message->value));
}

void check_stream(const Json& vector) {
  std::optional<protocol::Aes256> cipher_space;
  const auto& cipher = cipher_of(vector, cipher_space);
  CommandMemory memory;
  const std::vector<Json> lines = decode_all(hex_of(vector, "frame_hex"), cipher ? &*cipher : nullptr, memory);
  const Json delivered = vector.value("delivered", Json::array());
  if (!vector.contains("dji_quirk") || vector["dji_quirk"].is_null()) {
    ASSERT_EQ(lines.size(), delivered.size());
  }
}

TEST(Vectors, AreDecodedAndMadeAgainByteForByte) {
  RecordProperty("promise", "R2");
  M100_SHARED_FILE_OR_SKIP(path, "protocol/vectors.jsonl");
  const std::vector<Json> vectors = read_vectors(path);
  ASSERT_FALSE(vectors.empty());
  std::size_t accepted = 0;
  for (const Json& vector : vectors) {
    SCOPED_TRACE(vector.at("name").get<std::string>());
    if (vector.at("expected") == "accept") {
      check_accepted(vector);
      ++accepted;
    } else {
      check_stream(vector);
    }
  }
  EXPECT_GE(accepted, 66U);
}

}  // namespace
}  // namespace m100::lab
