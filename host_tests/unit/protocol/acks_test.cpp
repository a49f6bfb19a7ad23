// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/acks.h"

#include <gtest/gtest.h>

#include <vector>

namespace m100::protocol {
namespace {

VersionAnswer answer_with(std::string_view name) {
  VersionAnswer answer{.code = kAckNotAuthorised, .version_crc = 0xA6453AAC};
  std::copy(name.begin(), name.end(), answer.version_name.begin());
  return answer;
}

// Given one byte, DJI's SDK invents the second; given three, it throws.
TEST(Ack, IsExactlyTwoBytes) {
  const std::vector<std::byte> bytes(8, std::byte{2});
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    EXPECT_EQ(decode_ack(std::span(bytes).first(size)).has_value(), size == 2) << size;
  }
  EXPECT_EQ(*decode_ack(encode_ack(0xFF01)), 0xFF01);
}

TEST(Ack, EveryCodeOfEveryCommandHasANameAndRefusalsHaveARemedy) {
  struct Codes {
    MessageId command;
    std::vector<std::uint16_t> codes;
  };
  for (const Codes& row :
       {Codes{ids::kVersionQuery, {0, 0xFF01}},
        Codes{ids::kActivation, {0, 1, 2, 3, 4, 5, 6, 7, 8, 0xFF00, 0xFF01, 0xFF02}},
        Codes{ids::kTelemetryFrequency, {0, 1}}, Codes{ids::kControlRequest, {0, 1, 2, 3, 4, 0xC9, 0xFF00, 0xFF01}},
        Codes{ids::kMotors, {0, 1, 2, 3}}, Codes{ids::kTask, {1, 2}}, Codes{ids::kTaskQuery, {1, 3, 4, 5}}}) {
    for (const std::uint16_t code : row.codes) {
      const AckMeaning meaning = ack_meaning(row.command, code);
      EXPECT_NE(meaning.name, "unknown_code") << name(row.command) << ' ' << code;
      EXPECT_EQ(meaning.code, code);
      if (meaning.verdict != AckVerdict::kDone) {
        EXPECT_FALSE(meaning.remedy.empty()) << meaning.name;
      }
    }
  }
  EXPECT_EQ(ack_meaning(ids::kControlRequest, 77).name, "unknown_code");
  EXPECT_EQ(ack_meaning(ids::kControlRequest, control_ack::kObtaining).verdict, AckVerdict::kSendAgain);
}

struct VersionCase {
  const char* name;
  const char* text;
  std::uint32_t version;  ///< 0: refused
};

class SdkVersion : public ::testing::TestWithParam<VersionCase> {};

TEST_P(SdkVersion, IsReadFromTheText) {
  EXPECT_EQ(sdk_version(answer_with(GetParam().text)).value_or(0), GetParam().version);
}

INSTANTIATE_TEST_SUITE_P(
    Table, SdkVersion,
    ::testing::Values(VersionCase{"LastFirmwareCountsTens", "SDK-v1.0 BETA M100-03.01.01.00", 0x03010A00},
                      VersionCase{"AnA3", "SDK-v1.0 BETA A3-03.01.100.00", 0x03016400},
                      VersionCase{"OldFirmwareWroteThemOut", "SDK-v1.0 BETA M100-02.03.10.00", 0x02030A00},
                      VersionCase{"NoDash", "M100 03.01.01.00", 0}, VersionCase{"Nothing", "", 0},
                      VersionCase{"ThreeNumbers", "M100-03.01.01", 0},
                      VersionCase{"FiveNumbers", "M100-03.01.01.00.1", 0},
                      VersionCase{"Letters", "M100-03.0x.01.00", 0}, VersionCase{"TooLarge", "M100-03.01.99.00", 0},
                      VersionCase{"NumberAbove255", "A3-3.1.256.0", 0},
                      VersionCase{"NumberLeftOut", "M100-03..01.00", 0},
                      VersionCase{"LastLeftOut", "M100-03.01.01.", 0}),
    [](const auto& tested) { return tested.param.name; });

TEST(VersionAnswer, ComesIn49Bytes38BytesOrNotAtAll) {
  const VersionAnswer answer = answer_with("SDK-v1.0 BETA M100-03.01.01.00");
  const Value value = encode(answer);
  ASSERT_EQ(value.size(), VersionAnswer::kBytes);
  const auto again = decode_version_answer(value);
  ASSERT_TRUE(again);
  EXPECT_EQ(text(again->version_name), text(answer.version_name));
  EXPECT_FALSE(again->activated());

  std::vector<std::byte> old(value.bytes().begin(), value.bytes().begin() + 6);  // an answer without the device id
  old.insert(old.end(), value.bytes().begin() + 17, value.bytes().end());
  const auto from_old = decode_version_answer(old);
  ASSERT_TRUE(from_old);
  EXPECT_EQ(text(from_old->version_name), text(answer.version_name));
  EXPECT_EQ(text(from_old->device_id), "");
  for (std::size_t size = 0; size < 60; ++size) {
    const std::vector<std::byte> bytes(size);
    EXPECT_EQ(decode_version_answer(bytes).has_value(), size == 49 || size == 38) << size;
  }
}

}  // namespace
}  // namespace m100::protocol
