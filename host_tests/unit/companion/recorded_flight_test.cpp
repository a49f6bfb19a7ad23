// SPDX-License-Identifier: BSD-3-Clause
// Reads a flight log back: every stream in its place; a truncated end is left out; a damaged log is refused with the
// byte's number.
#include "firmware/companion/files/recorded_flight.h"

#include <gtest/gtest.h>

#include <cstddef>

#include "firmware/log/flight_log.h"
#include "host_tests/own_folder.h"
#include "host_tests/refusal.h"

namespace m100::companion {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> counting(std::size_t count, unsigned first) {
  std::vector<std::byte> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = static_cast<std::byte>(first + i);
  }
  return out;
}

struct RecordedFlightTest : host_tests::FolderTest {
  /// Two ticks: the first has bytes of every stream, one of them longer than one record; the second is excited.
  static std::string two_ticks() {
    std::vector<std::byte> storage(1U << 16U);
    log::Ring ring(storage);
    log::FlightLogWriter log(ring);
    const std::array<log::Note, 2> notes{log::Note{"m100_course", "hover"}, log::Note{"m100_start", "0 0 1 0"}};
    EXPECT_EQ(log.begin(core::TimePoint(core::Duration(5)), notes), core::Status::kOk);
    const core::TimePoint now(core::Duration(10000));
    log.append(log::Stream::kAutopilotIn, now, counting(130, 0));
    log.append(log::Stream::kAutopilotOut, now, counting(2, 50));
    log.append(log::Stream::kPoseIn, now, counting(3, 60));
    log.append(log::Stream::kPoseOut, now, counting(4, 70));
    log::TickRecord record;
    record.timestamp = 10000;
    record.orders = 3;
    log.append(record);
    log::ExcitationRecord excitation;
    excitation.timestamp = 20000;
    excitation.counts = -7;
    log.append(excitation);
    log.append(log::VibrationRecord{.timestamp = 20000, .rms = 0.03F});
    record.timestamp = 20000;
    log.append(record);
    EXPECT_EQ(log.dropped(), 0U);
    std::string out;
    ring.drain([&out](std::span<const std::byte> piece) {
      out.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    });
    return out;
  }
  RecordedFlight read(const std::string& bytes) const { return read_flight(made("a.ulg", bytes)); }
  std::string refusal(const std::string& bytes) const {
    const std::string said = host_tests::refusal_by<FlightLogError>([&] { (void)read(bytes); });
    return said.empty() ? "" : said.substr(path("a.ulg").size());
  }
};

TEST_F(RecordedFlightTest, HoldsEveryStreamOfEveryTick) {
  const RecordedFlight flight = read(two_ticks());
  ASSERT_EQ(flight.ticks.size(), 2U);
  EXPECT_EQ(flight.notes.at("m100_course"), "hover");
  EXPECT_EQ(flight.notes.at("m100_start"), "0 0 1 0");
  const RecordedFlight::Tick& first = flight.ticks[0];
  EXPECT_EQ(first.autopilot_in, counting(130, 0));
  EXPECT_EQ(first.autopilot_out, counting(2, 50));
  EXPECT_EQ(first.pose_in, counting(3, 60));
  EXPECT_EQ(first.pose_out, counting(4, 70));
  EXPECT_EQ(first.record.timestamp, 10000U);
  EXPECT_EQ(first.record.orders, 3U);
  EXPECT_FALSE(first.excitation);
  const RecordedFlight::Tick& second = flight.ticks[1];
  EXPECT_TRUE(second.autopilot_in.empty() && second.pose_out.empty());
  EXPECT_EQ(second.record.timestamp, 20000U);
  ASSERT_TRUE(second.excitation);
  EXPECT_EQ(second.excitation->counts, -7);
}

// After a loss of power the file ends anywhere: every tick before the end is read, and no incomplete one.
TEST_F(RecordedFlightTest, EndsWithTheLastWholeTickWhereverItIsCut) {
  const std::string whole = two_ticks();
  const std::size_t tick_bytes = sizeof(log::TickRecord) + 5;
  const std::size_t first_ends =
      whole.size() - tick_bytes - sizeof(log::ExcitationRecord) - sizeof(log::VibrationRecord) - 10;
  for (std::size_t size = first_ends - tick_bytes; size <= whole.size(); ++size) {
    const std::size_t ticks = size < first_ends ? 0 : size < whole.size() ? 1 : 2;
    ASSERT_EQ(read(whole.substr(0, size)).ticks.size(), ticks) << size << " of " << whole.size();
  }
}

TEST_F(RecordedFlightTest, WhatIsNotOursIsRefusedByItsByte) {
  const std::string whole = two_ticks();
  const std::string none = ": byte 0: not a ULog file";
  EXPECT_EQ(refusal(""), none);
  EXPECT_EQ(refusal(whole.substr(0, 15)), none);
  for (std::size_t at = 0; at < 8; ++at) {
    std::string other = whole;
    other[at] = static_cast<char>(other[at] ^ 1);
    EXPECT_EQ(refusal(other), none) << at;
  }
  EXPECT_EQ(refusal(whole.substr(0, 16)),
            ": byte 16: no tick record: not a log of this program, or of another version");
  const auto with = [&whole](const std::string& find, std::size_t at, char value) {
    std::string other = whole;
    const std::size_t place = other.find(find);
    EXPECT_NE(place, std::string::npos) << find;
    other[place + at] = value;
    return other;
  };
  EXPECT_NE(refusal(with("tick:", 6, 'x')).find("tick record of another version"), std::string::npos);
  EXPECT_NE(refusal(with("link_bytes:", 12, 'x')).find("byte record of another version"), std::string::npos);
  // The message number of the excitation's record, after its size and its type.
  std::string renumbered = whole;
  constexpr std::size_t kBesideTick = sizeof(log::ExcitationRecord) + 5 + sizeof(log::VibrationRecord) + 5;
  renumbered[whole.size() - sizeof(log::TickRecord) - 5 - kBesideTick + 3] = 7;
  EXPECT_NE(refusal(renumbered).find("data record of unknown size"), std::string::npos);
  std::string too_long = whole;
  const std::size_t bytes =
      whole.size() - sizeof(log::TickRecord) - 5 - kBesideTick - sizeof(log::TickRecord) - 5 - sizeof(log::BytesRecord);
  ASSERT_EQ(too_long[bytes + 9], 4) << "the four bytes of the pose's answer";
  too_long[bytes + 9] = 118;
  EXPECT_EQ(refusal(too_long), "");
  too_long[bytes + 9] = 119;
  EXPECT_NE(refusal(too_long).find("byte record with an impossible length"), std::string::npos);
}

TEST_F(RecordedFlightTest, ADamagedNoteIsRefused) {
  const std::string whole = two_ticks();
  const std::size_t key = whole.find("m100_course") - std::string("char[5] ").size() - 1;
  std::string longer = whole;
  longer[key] = static_cast<char>(0xFF);
  EXPECT_NE(refusal(longer).find("damaged note"), std::string::npos);
}

}  // namespace
}  // namespace m100::companion
