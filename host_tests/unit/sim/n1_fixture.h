// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/world/still_vehicle.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_encoder.h"

/// The emulated autopilot as the raw frames of a client see it: a cable, a hovering vehicle, and a clock that the test
/// advances.
namespace m100::sim {

using std::chrono::milliseconds;
using std::chrono::seconds;
namespace ids = protocol::ids;

inline std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> result;
  for (const unsigned value : values) {
    result.push_back(static_cast<std::byte>(value));
  }
  return result;
}

struct Heard {
  protocol::FrameHeader header;
  protocol::MessageId id;
  std::vector<std::byte> value;
};

struct N1Test : ::testing::Test {
  void start(const N1Config& config) { autopilot.emplace(cable.b(), vehicle, config); }
  void SetUp() override { start({}); }

  /// Sends a command in a session, waits, and returns the value of its acknowledgement.
  std::optional<std::vector<std::byte>> ask(protocol::MessageId id, const std::vector<std::byte>& value,
                                            std::uint8_t session = 2, const protocol::Cipher* cipher = nullptr) {
    ++sequence;
    return ask_again(id, value, session, cipher);
  }
  std::optional<std::vector<std::byte>> ask_again(protocol::MessageId id, const std::vector<std::byte>& value,
                                                  std::uint8_t session = 2, const protocol::Cipher* cipher = nullptr) {
    send(id, value, session, cipher);
    heard.clear();
    run(milliseconds(30));
    for (const Heard& frame : heard) {
      if (frame.header.is_ack && frame.header.session == session && frame.header.sequence == sequence) {
        return frame.value;
      }
    }
    return std::nullopt;
  }
  unsigned code(protocol::MessageId id, const std::vector<std::byte>& value) {
    const auto answer = ask(id, value);
    EXPECT_TRUE(answer && answer->size() == 2U) << "acknowledgements are two bytes";
    return answer && answer->size() == 2
               ? std::to_integer<unsigned>((*answer)[0]) | std::to_integer<unsigned>((*answer)[1]) << 8U
               : 0xDEADU;
  }
  void send(protocol::MessageId id, const std::vector<std::byte>& value, std::uint8_t session = 0,
            const protocol::Cipher* cipher = nullptr) {
    std::array<std::byte, 256> space;
    const auto frame = protocol::encode_frame(
        {.session = session, .is_ack = false, .encrypted = cipher != nullptr, .sequence = sequence}, &id, value, space,
        cipher);
    ASSERT_TRUE(frame.has_value());
    ASSERT_TRUE(cable.a().write(*frame).has_value());
  }
  void run(core::Duration time) {
    for (const core::TimePoint end = clock.now() + time; clock.now() < end;) {
      clock.advance(N1Autopilot::kTick);
      autopilot->advance(clock.now());
      std::array<std::byte, 512> buffer;
      const std::size_t count = cable.a().read(buffer).value();
      parser.consume(std::span(buffer).first(count), [&](const protocol::FrameView& frame) {
        protocol::CipherScratch scratch;
        const auto message = protocol::open(frame, cipher_of_client, scratch);
        ASSERT_TRUE(message.has_value());
        heard.push_back({message->header, message->id, {message->value.begin(), message->value.end()}});
      });
    }
  }
  void activate() {
    std::vector<std::byte> value(44);
    value[4] = std::byte{2};
    value[9] = std::byte{0x0A};
    value[10] = std::byte{0x01};
    value[11] = std::byte{0x03};
    ASSERT_EQ(code(ids::kActivation, value), 0U);
  }
  void obtain() {
    activate();
    ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
    ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  }
  std::size_t pushes(protocol::MessageId id) const {
    std::size_t count = 0;
    for (const Heard& frame : heard) {
      count += !frame.header.is_ack && frame.id == id && frame.header.session == 0 ? 1U : 0U;
    }
    return count;
  }
  protocol::Telemetry last_control() {
    heard.clear();
    run(milliseconds(40));
    protocol::Telemetry telemetry;
    for (const Heard& frame : heard) {
      if (frame.id == ids::kTelemetry && !frame.header.is_ack) {
        EXPECT_EQ(protocol::decode_telemetry(frame.value, telemetry), core::Status::kOk);
      }
    }
    return telemetry;
  }
  void fast_rates() {
    ASSERT_EQ(code(ids::kTelemetryFrequency, bytes({3, 3, 3, 3, 3, 3, 0, 3, 0, 3, 3, 3, 0, 0, 0, 0})), 0U);
  }

  hal::ManualClock clock;
  hal::UartPair cable{clock, 230400};
  StillVehicle vehicle;
  std::optional<N1Autopilot> autopilot;
  protocol::FrameParser parser;
  std::vector<Heard> heard;
  std::uint16_t sequence = 100;
  const protocol::Cipher* cipher_of_client = nullptr;
};

}  // namespace m100::sim
