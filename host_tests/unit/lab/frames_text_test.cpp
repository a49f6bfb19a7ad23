// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/frames/frame_text.h"

#include <gtest/gtest.h>

#include "host_tests/lab/frames/hex.h"
#include "host_tests/lab/frames/message_json.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/refusal.h"
#include "protocol/aes256.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"

namespace m100::lab {
namespace {

const std::string kKeyHex(64, 'a');

struct BadLine {
  const char* name;
  const char* line;
  const char* message;
};

class FrameLine : public ::testing::TestWithParam<BadLine> {};

// A bad line gives one error that names file, line and key.
TEST_P(FrameLine, IsRefusedByName) {
  const auto read = [] { (void)frame_from_line(Json::parse(GetParam().line), {"frames.jsonl", 7}, std::nullopt); };
  EXPECT_EQ(host_tests::refusal_by<InputError>(read), std::string("frames.jsonl:7: ") + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Table, FrameLine,
    ::testing::Values(
        BadLine{"NoSession", R"({})", "'session': must be a whole number"},
        BadLine{"SessionTooLarge", R"({"session":32})", "'session': must be 0 to 31"},
        BadLine{"SessionIsText", R"({"session":"2"})", "'session': must be a whole number"},
        BadLine{"NoAckFlag", R"({"session":2,"is_ack":1})", "'is_ack': must be true or false"},
        BadLine{"SequenceNegative", R"({"session":2,"is_ack":false,"encrypted":false,"seq":-1})",
                "'seq': must be 0 to 65535"},
        BadLine{"HalfAnId", R"({"session":2,"is_ack":false,"encrypted":false,"seq":1,"cmd_set":1})",
                "'cmd_id': must be a whole number"},
        BadLine{"NoPayload", R"({"session":2,"is_ack":false,"encrypted":false,"seq":1,"payload_hex":null})",
                "'payload_hex': must be a text"},
        BadLine{"OddPayload", R"({"session":2,"is_ack":false,"encrypted":false,"seq":1,"payload_hex":"abc"})",
                "'payload_hex': must be pairs of hexadecimal digits"},
        BadLine{"AckWithId",
                R"({"session":2,"is_ack":true,"encrypted":false,"seq":1,"cmd_set":1,"cmd_id":0,"payload_hex":""})",
                "'payload_hex': an acknowledgement carries no cmd_set, and an encrypted frame needs data"},
        BadLine{"NoKey", R"({"session":2,"is_ack":true,"encrypted":true,"seq":1,"payload_hex":"00"})",
                "'key_hex': an encrypted frame needs its key_hex (or --key-file)"},
        BadLine{"ShortKey", R"({"session":2,"is_ack":true,"encrypted":true,"seq":1,"payload_hex":"00","key_hex":"00"})",
                "'key_hex': a key is 64 hexadecimal digits"}),
    [](const auto& tested) { return tested.param.name; });

TEST(FrameLine, FillerMustHaveItsLength) {
  Json line = Json::parse(R"({"session":2,"is_ack":true,"encrypted":true,"seq":1,"payload_hex":"0000"})");
  line["key_hex"] = kKeyHex;
  line["padding_hex"] = "00";
  EXPECT_THROW((void)frame_from_line(line, {}, std::nullopt), InputError);
  line["padding_hex"] = std::string(28, '1');
  EXPECT_NO_THROW((void)frame_from_line(line, {}, std::nullopt));
}

/// The JSON line of one frame.
Json decode_one(const std::vector<std::byte>& bytes, const protocol::Cipher* cipher, CommandMemory& memory) {
  protocol::FrameParser parser;
  EXPECT_EQ(parser.push(bytes), bytes.size());
  const auto frame = parser.poll();
  return frame ? frame_line(*frame, cipher, memory) : Json();
}

std::vector<std::byte> frame_of(const protocol::Envelope& envelope, const protocol::MessageId* id,
                                std::span<const std::byte> value, const protocol::Cipher* cipher = nullptr) {
  std::array<std::byte, protocol::kMaxFrameBytes> space;
  const auto bytes = encode_frame(envelope, id, value, space, cipher);
  return {bytes->begin(), bytes->end()};
}

TEST(FrameJson, WithoutTheKeyNothingIsGuessed) {
  const protocol::Aes256 cipher(parse_key(kKeyHex, {}, "key"));
  const std::vector<std::byte> bytes = frame_of({.session = 2, .encrypted = true, .sequence = 1},
                                                &protocol::ids::kControlRequest, std::array{std::byte{1}}, &cipher);
  CommandMemory memory;
  const Json hidden = decode_one(bytes, nullptr, memory);
  EXPECT_TRUE(hidden["cmd_set"].is_null());
  EXPECT_TRUE(hidden["payload_hex"].is_null());
  Json open = decode_one(bytes, &cipher, memory);
  EXPECT_EQ(open["name"], "obtain_control");
  open["key_hex"] = kKeyHex;
  EXPECT_EQ(to_hex(frame_from_line(open, {}, std::nullopt)), to_hex(bytes));
}

// An acknowledgement carries no id; only the command in the same recording identifies it.
TEST(FrameJson, AnAnswerIsNamedByTheCommandBeforeIt) {
  const std::vector<std::byte> answer = frame_of({.session = 2, .is_ack = true, .sequence = 9}, nullptr,
                                                 protocol::encode_ack(protocol::control_ack::kObtaining));
  CommandMemory memory;
  EXPECT_EQ(decode_one(answer, nullptr, memory)["name"], "ack");
  const std::vector<std::byte> command =
      frame_of({.session = 2, .sequence = 9}, &protocol::ids::kControlRequest, std::array{std::byte{1}});
  (void)decode_one(command, nullptr, memory);
  const Json named = decode_one(answer, nullptr, memory);
  EXPECT_EQ(named["name"], "ack_control");
  EXPECT_EQ(named["fields"]["meaning"], "obtain_pending_resend");
}

TEST(FrameJson, WrongSizesAreMarkedAndKept) {
  CommandMemory memory;
  const std::vector<std::byte> value(16);
  const Json movement = decode_one(frame_of({}, &protocol::ids::kMovement, value), nullptr, memory);
  EXPECT_EQ(movement["name"], "movement");
  EXPECT_EQ(movement["malformed"], true);
  EXPECT_EQ(movement["payload_hex"], std::string(32, '0'));
  const protocol::MessageId nobodys{9, 9};
  EXPECT_EQ(decode_one(frame_of({}, &nobodys, value), nullptr, memory)["name"], "unknown");
}

}  // namespace
}  // namespace m100::lab
