// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/log/flight_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace m100::log {
namespace {

std::vector<std::uint8_t> drained(Ring& ring) {
  std::vector<std::uint8_t> out;
  ring.drain([&out](std::span<const std::byte> piece) {
    std::transform(piece.begin(), piece.end(), std::back_inserter(out), std::to_integer<std::uint8_t>);
  });
  return out;
}

struct Message {
  char type;
  std::string body;
};
std::vector<Message> messages(const std::vector<std::uint8_t>& file) {
  std::vector<Message> out;
  for (std::size_t at = 16; at + 3 <= file.size();) {
    const std::size_t size = file[at] + 256U * file[at + 1];
    out.push_back({static_cast<char>(file[at + 2]), std::string(file.begin() + static_cast<long>(at) + 3,
                                                                file.begin() + static_cast<long>(at + 3 + size))});
    at += 3 + size;
  }
  return out;
}

/// The messages that are left in the ring after the file's head.
std::vector<Message> remaining(Ring& ring) {
  std::vector<std::uint8_t> file(16);
  const std::vector<std::uint8_t> rest = drained(ring);
  file.insert(file.end(), rest.begin(), rest.end());
  return messages(file);
}

std::size_t bytes_of_format(std::string_view format) {
  const std::map<std::string_view, std::size_t> sizes{{"uint64_t", 8}, {"double", 8},  {"float", 4},  {"uint32_t", 4},
                                                      {"uint16_t", 2}, {"int16_t", 2}, {"uint8_t", 1}};
  std::size_t total = 0;
  for (std::size_t at = format.find(':') + 1; at < format.size(); at = format.find(';', at) + 1) {
    const std::string_view type = format.substr(at, format.find(' ', at) - at);
    const std::size_t bracket = type.find('[');
    const std::size_t count = bracket == std::string_view::npos ? 1 : std::stoul(std::string(type.substr(bracket + 1)));
    total += count * sizes.at(type.substr(0, bracket));
  }
  return total;
}

// Catches a field that was added to the record but not to its description, or the other way round.
TEST(Records, AreAsTheirFormatsSay) {
  EXPECT_EQ(bytes_of_format(kTickFormat), sizeof(TickRecord));
  EXPECT_EQ(bytes_of_format(kBytesFormat), sizeof(BytesRecord));
  EXPECT_EQ(bytes_of_format(kExcitationFormat), sizeof(ExcitationRecord));
  EXPECT_EQ(bytes_of_format(kVibrationFormat), sizeof(VibrationRecord));
}

TEST(FlightLog, BeginsAsUlogDoes) {
  std::vector<std::byte> storage(16384);
  Ring ring(storage);
  FlightLogWriter log(ring);
  const std::array notes{Note{"vehicle", "[axis.roll]\n"}};
  ASSERT_EQ(log.begin(core::TimePoint(std::chrono::microseconds(0x0102)), notes), core::Status::kOk);
  const std::vector<std::uint8_t> file = drained(ring);
  const std::vector<std::uint8_t> expected{0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01,
                                           0x02, 0x01, 0,    0,    0,    0,    0,    0};
  EXPECT_EQ(std::vector<std::uint8_t>(file.begin(), file.begin() + 16), expected);
  const std::vector<Message> all = messages(file);
  std::string types;
  for (const Message& one : all) {
    types += one.type;
  }
  EXPECT_EQ(types, "BFFFFIAAAA");
  EXPECT_EQ(all[0].body, std::string(40, '\0'));
  EXPECT_EQ(all[5].body,
            "\x10"
            "char[12] vehicle"
            "[axis.roll]\n");
  EXPECT_EQ(all[6].body, std::string("\0\0\0tick", 7));
}

// Catches a note that is truncated without an error: a replay would read half a course as a damaged one, or fly it.
TEST(FlightLog, RefusesANoteThatIsTooLongAndLeavesItOut) {
  std::vector<std::byte> storage(262144);
  for (const std::size_t size : {kLongestNote_bytes, kLongestNote_bytes + 1}) {
    Ring ring(storage);
    FlightLogWriter log(ring);
    const std::string text(size, 'x');
    const std::array notes{Note{"course", text}, Note{"start", "1 2 3"}};
    const bool fits = size == kLongestNote_bytes;
    EXPECT_EQ(log.begin(core::TimePoint{}, notes), fits ? core::Status::kOk : core::Status::kResourceExhausted);
    std::size_t announced = 0;
    for (const Message& message : messages(drained(ring))) {
      announced += message.type == 'I' ? 1U : 0U;
      EXPECT_TRUE(message.type != 'I' || message.body.find("course") == std::string::npos ||
                  message.body.size() > size);
    }
    EXPECT_EQ(announced, fits ? 2U : 1U);
  }
}

TEST(FlightLog, KeepsEveryByteOfALongRead) {
  std::vector<std::byte> storage(4096);
  Ring ring(storage);
  FlightLogWriter log(ring);
  std::vector<std::byte> sent(300);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    sent[i] = static_cast<std::byte>(i);
  }
  log.append(Stream::kAutopilotIn, core::TimePoint(std::chrono::seconds(1)), sent);
  std::vector<std::byte> back;
  for (const Message& one : remaining(ring)) {
    BytesRecord record;
    std::memcpy(&record, one.body.data() + 2, sizeof record);
    EXPECT_EQ(record.timestamp, 1000000U);
    for (std::size_t i = 0; i < record.count; ++i) {
      back.push_back(static_cast<std::byte>(record.bytes[i]));
    }
  }
  EXPECT_EQ(back, sent);
}

// A slow medium may only lose whole messages, never a part of one, and may never block.
TEST(FlightLog, DropsWholeMessagesWhenNobodyEmptiesTheRing) {
  std::vector<std::byte> storage(1024);
  Ring ring(storage);
  FlightLogWriter log(ring);
  TickRecord record;
  for (std::uint64_t i = 0; i < 10; ++i) {
    record.timestamp = i;
    log.append(record);
  }
  EXPECT_GT(log.dropped(), 0U);
  const std::vector<Message> all = remaining(ring);
  EXPECT_EQ(all.size(), 10U - log.dropped());
  for (const Message& one : all) {
    EXPECT_EQ(one.type, 'D');
    EXPECT_EQ(one.body.size(), sizeof(TickRecord) + 2);
  }
}

// An older log must keep its meaning, and its replay must give the same orders, so the values of the bits must not
// change.
TEST(TickRecord, OrdersAreTheBitsThatOlderLogsHold) {
  EXPECT_EQ(kOrderEngage, 1U);
  EXPECT_EQ(kOrderRelease, 2U);
  EXPECT_EQ(kOrderTakesOff, 4U);
  EXPECT_EQ(kOrderLands, 8U);
  EXPECT_EQ(kOrderTask, 16U);
}

TEST(Ring, GivesBackWhatWentInAcrossItsEnd) {
  std::vector<std::byte> storage(64);
  Ring ring(storage);
  std::vector<std::uint8_t> in;
  std::vector<std::uint8_t> out;
  std::uint8_t value = 0;
  for (int round = 0; round < 50; ++round) {
    std::vector<std::byte> piece(static_cast<std::size_t>(1 + round % 23));
    for (std::byte& one : piece) {
      one = static_cast<std::byte>(value);
      in.push_back(value++);
    }
    ASSERT_TRUE(ring.push({}, piece));
    for (const std::uint8_t one : drained(ring)) {
      out.push_back(one);
    }
  }
  EXPECT_EQ(in, out);
}

TEST(FlightLog, WritesTextAndAnExcitationAsUlogHasThem) {
  std::vector<std::byte> storage(131072);
  Ring ring(storage);
  FlightLogWriter log(ring);
  ASSERT_EQ(log.begin(core::TimePoint{}, {}), core::Status::kOk);
  (void)drained(ring);
  log.append(core::TimePoint(std::chrono::microseconds(0x0102030405060708)), "control is back");
  ExcitationRecord record;
  record.counts = -3;
  log.append(record);
  log.append(core::TimePoint{}, std::string(60001, 'x'));
  const std::vector<Message> all = remaining(ring);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].type, 'L');
  EXPECT_EQ(all[0].body,
            "6\x08\x07\x06\x05\x04\x03\x02\x01"
            "control is back")
      << "level, time, text";
  EXPECT_EQ(all[1].type, 'D');
  EXPECT_EQ(all[1].body.substr(0, 2), std::string("\x02\0", 2));
  EXPECT_EQ(all[1].body.substr(2), std::string(reinterpret_cast<const char*>(&record), sizeof record));
  EXPECT_EQ(all[2].body.size(), 9U + 60000U) << "a text is cut where a message would not hold it";
}

// Catches a beginning that reports success although one of its messages found no room; every message is tried.
TEST(FlightLog, SaysWhetherItsWholeBeginningFoundRoom) {
  const std::array notes{Note{"vehicle", "[axis.roll]\n"}};
  std::vector<std::byte> large(16384);
  Ring ring(large);
  FlightLogWriter whole(ring);
  ASSERT_EQ(whole.begin(core::TimePoint{}, notes), core::Status::kOk);
  const std::size_t size = drained(ring).size();
  const std::vector<std::byte> before(large.size());
  for (std::size_t room = 0; room <= size + 2; ++room) {
    Ring small(large);
    ASSERT_TRUE(small.push(std::span(before).first(large.size() - room), {}));
    FlightLogWriter log(small);
    EXPECT_EQ(log.begin(core::TimePoint{}, notes) == core::Status::kOk, room >= size) << room << " of " << size;
    EXPECT_EQ(log.dropped() == 0, room >= size) << room;
  }
}

}  // namespace
}  // namespace m100::log
