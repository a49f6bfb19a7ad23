// SPDX-License-Identifier: BSD-3-Clause
// The counts of sessions, the order message of the bare board, and the edges of the telemetry layouts.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "protocol/dji/acks.h"
#include "protocol/dji/order_message.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry_layout.h"

namespace m100::protocol {
namespace {

using std::chrono::milliseconds;

// An operator sees a bad cable in these counts; a count that starts at one, or counts twice, misleads.
TEST(RequestSessions, CountWhatHappened) {
  RequestSessions sessions;
  const core::TimePoint start{std::chrono::seconds(1)};
  const std::array<std::byte, 1> value{std::byte{1}};
  const RequestOptions twice{.timeout = milliseconds(100), .transmissions = 2, .cipher = nullptr};
  EXPECT_EQ(sessions.stats().requests + sessions.stats().repeats + sessions.stats().answers +
                sessions.stats().failures + sessions.stats().stray_answers,
            0U);
  ASSERT_TRUE(sessions.request(ids::kTask, value, twice, start));
  ASSERT_TRUE(sessions.request(ids::kMotors, value, twice, start));
  EXPECT_TRUE(sessions.is_open(ids::kTask));
  EXPECT_FALSE(sessions.is_open(ids::kControlRequest));
  EXPECT_EQ(sessions.open_count(), 2U);
  Message answer;
  answer.header = {.session = 2, .is_ack = true, .sequence = 0};
  const auto taken = sessions.accept(answer, start + milliseconds(30));
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->session, 2);
  EXPECT_EQ(taken->sequence, 0);
  EXPECT_EQ(taken->transmissions, 1);
  EXPECT_EQ(sessions.poll(start + milliseconds(101))->frame.sequence, 1);
  EXPECT_EQ(sessions.poll(start + milliseconds(202))->kind, Due::Kind::kFailed);
  EXPECT_EQ(sessions.stats().requests, 2U);
  EXPECT_EQ(sessions.stats().answers, 1U);
  EXPECT_EQ(sessions.stats().repeats, 1U);
  EXPECT_EQ(sessions.stats().failures, 1U);
  EXPECT_EQ(sessions.stats().stray_answers, 0U);
  for (const std::uint8_t session : {std::uint8_t{0}, std::uint8_t{1}}) {
    answer.header.session = session;
    EXPECT_EQ(sessions.accept(answer, start).status(), core::Status::kRefused);
  }
  EXPECT_EQ(sessions.stats().stray_answers, 2U);
}

TEST(AnswerSessions, CountWhatHappened) {
  AnswerSessions sessions;
  EXPECT_EQ(sessions.stats().executed + sessions.stats().repeated + sessions.stats().unfinished, 0U);
  FrameHeader ack{.session = 5, .is_ack = true, .sequence = 1};
  EXPECT_EQ(sessions.accept(ack).verdict, AnswerSessions::Verdict::kIgnore);
  EXPECT_EQ(sessions.answer(ack, encode_ack(2)).status(), core::Status::kInvalidArgument);
  const FrameHeader asked{.session = 31, .sequence = 1};
  (void)sessions.accept(asked);
  (void)sessions.accept(asked);
  ASSERT_TRUE(sessions.answer(asked, encode_ack(2)));
  (void)sessions.accept(asked);
  (void)sessions.accept({.session = 0, .sequence = 9});
  EXPECT_EQ(sessions.stats().executed, 2U);
  EXPECT_EQ(sessions.stats().unfinished, 1U);
  EXPECT_EQ(sessions.stats().repeated, 1U);
}

// The switch of the bare board: a message with one changed bit is not an order.
TEST(OrderMessage, IsTakenWholeAndUnchangedOnly) {
  for (const bool flies : {false, true}) {
    const OrderBytes good = encode_order(flies);
    for (std::size_t bit = 0; bit <= 8 * good.size(); ++bit) {
      OrderBytes sent = good;
      if (bit < 8 * good.size()) {
        sent[bit / 8] ^= std::byte{1} << (bit % 8);
      }
      OrderParser parser;
      core::Expected<bool> last = core::Status::kNotReady;
      for (const std::byte value : sent) {
        EXPECT_FALSE(last) << "before its last byte";
        last = parser.push(value);
      }
      EXPECT_EQ(last.has_value(), bit == 8 * good.size()) << "bit " << bit;
      EXPECT_EQ(last.value_or(!flies), bit == 8 * good.size() ? flies : !flies);
    }
  }
  OrderParser parser;
  core::Expected<bool> last = core::Status::kNotReady;
  for (std::byte value : encode_order(true)) {
    last = parser.push(value);
  }
  EXPECT_TRUE(last);
  EXPECT_EQ(parser.push(std::byte{0}).status(), core::Status::kNotReady);
  OrderBytes third = encode_order(true);
  third[3] = std::byte{2};
  for (const std::byte value : third) {
    EXPECT_EQ(parser.push(value).status(), core::Status::kNotReady) << "there is no third position";
  }
}

TelemetryLayout layout_of(std::string_view text) {
  VersionAnswer answer;
  std::copy(text.begin(), text.end(), answer.version_name.begin());
  return telemetry_layout(answer);
}

TEST(Layout, IsKnownAtTheEdgesOfTheVersions) {
  EXPECT_EQ(layout_of("M100-03.00.00.00"), TelemetryLayout::kM100) << "without a word in front";
  EXPECT_EQ(layout_of("SDK M100-04.00.00.00"), TelemetryLayout::kM100);
  EXPECT_EQ(layout_of("SDK A3-03.00.00.00"), TelemetryLayout::kUnknown);
  EXPECT_EQ(layout_of("SDK N3-03.01.00.00"), TelemetryLayout::kFamily);
  EXPECT_EQ(layout_of("SDK N3-04.00.00.00"), TelemetryLayout::kLaterFamily);
  EXPECT_EQ(layout_of("SDK M600-03.02.00.00"), TelemetryLayout::kFamily);
  EXPECT_EQ(layout_of("SDK XA3-03.02.00.00"), TelemetryLayout::kUnknown);
  EXPECT_EQ(name(TelemetryLayout::kM100), "m100");
  EXPECT_EQ(name(TelemetryLayout::kFamily), "family");
  EXPECT_EQ(name(TelemetryLayout::kOldM100), "old_m100");
  EXPECT_EQ(name(TelemetryLayout::kLaterFamily), "later_family");
  EXPECT_EQ(name(TelemetryLayout::kUnknown), "unknown_controller");
}

TEST(Layout, OnlyTheFamilyMovesItemsAndFromTheMagnetometerOn) {
  const auto family = rate_places(TelemetryLayout::kFamily);
  const auto m100 = rate_places(TelemetryLayout::kM100);
  for (std::uint8_t item = 0; item < 12; ++item) {
    EXPECT_EQ(family[item], item < 6 ? item : item + 2) << unsigned{item};
    EXPECT_EQ(m100[item], item);
  }
}

TEST(FamilyTelemetry, TakesOneOfTheTwoItemsThatAnM100DoesNotHave) {
  Telemetry telemetry;
  FamilyItems more;
  more.rtk.yaw = 12;
  std::vector<std::byte> gps(2 + 32);
  gps[0] = std::byte{0x40};
  gps[2] = std::byte{5};
  ASSERT_EQ(decode_family_telemetry(gps, telemetry, more), core::Status::kOk);
  EXPECT_TRUE(more.has_gps_detail);
  EXPECT_FALSE(more.has_rtk);
  EXPECT_EQ(more.gps_detail.date, 5U);
  EXPECT_EQ(more.rtk.yaw, 12) << "what did not come stays";
  std::vector<std::byte> rtk(2 + 44);
  rtk[0] = std::byte{0x80};
  rtk[2] = std::byte{6};
  ASSERT_EQ(decode_family_telemetry(rtk, telemetry, more), core::Status::kOk);
  EXPECT_TRUE(more.has_rtk);
  EXPECT_FALSE(more.has_gps_detail);
  EXPECT_EQ(more.rtk.date, 6U);
  EXPECT_EQ(more.rtk.yaw, 0);
  EXPECT_EQ(more.gps_detail.date, 5U);
  EXPECT_EQ(decode_family_telemetry(std::span(rtk).first(1), telemetry, more), core::Status::kInvalidArgument);
}

}  // namespace
}  // namespace m100::protocol
