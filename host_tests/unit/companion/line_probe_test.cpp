// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <vector>

#include "firmware/companion/preflight/probe/line_probe.h"
#include "hal/mock/wrong_baud.h"
#include "host_tests/sim/autopilot/n1_telemetry.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::companion {
namespace {

std::vector<std::byte> frame(const protocol::MessageId* id, std::span<const std::byte> value, bool is_ack = false) {
  std::array<std::byte, protocol::kMaxFrameBytes> space;
  const auto bytes = protocol::encode_frame(
      {.session = static_cast<std::uint8_t>(is_ack ? 2 : 0), .is_ack = is_ack, .encrypted = false, .sequence = 7}, id,
      value, space);
  return {bytes->begin(), bytes->end()};
}

std::vector<std::byte> telemetry() {
  sim::Random random(1, "probe");
  protocol::Telemetry report = sim::report({}, 400, {}, random);
  report.items = protocol::kAllTelemetryItems;
  return frame(&protocol::ids::kTelemetry, encode(report));
}

std::vector<std::byte> times(std::size_t count, const std::vector<std::byte>& bytes) {
  std::vector<std::byte> all;
  for (std::size_t i = 0; i < count; ++i) {
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  return all;
}

LineProbe after(const std::vector<std::byte>& bytes) {
  LineProbe listener;
  listener.receive(bytes);
  return listener;
}

TEST(Probe, NamesWhatItHears) {
  EXPECT_EQ(LineProbe{}.verdict(), Verdict::kNothingReceived);
  EXPECT_EQ(after(times(20, telemetry())).verdict(), Verdict::kAutopilot);
  EXPECT_EQ(after(times(20, frame(nullptr, protocol::encode_ack(0), true))).verdict(), Verdict::kApiNotEnabled);
  EXPECT_EQ(after(hal::received_at(times(20, telemetry()), 921600, 230400)).verdict(), Verdict::kWrongBaud);
  EXPECT_EQ(after(hal::received_at(times(20, telemetry()), 230400, 921600)).verdict(), Verdict::kWrongBaud);
  std::vector<std::byte> noisy = times(20, telemetry());
  for (std::size_t i = 100; i < noisy.size(); i += 600) {
    noisy[i] ^= std::byte{0x10};
  }
  EXPECT_EQ(after(noisy).verdict(), Verdict::kNoisy);
}

core::Expected<hal::LineErrors> counted(const hal::LineErrors& errors) { return errors; }

// The same bytes can have different causes with different remedies; the port's error counts tell them apart.
TEST(Probe, NoiseAWrongBaudRateAnotherDeviceAndASlowMachineLookDifferent) {
  const std::vector<std::byte> other_rate = hal::received_at(times(20, telemetry()), 921600, 230400);
  const auto bytes = static_cast<std::uint32_t>(other_rate.size());
  const LineProbe listener = after(other_rate);
  EXPECT_EQ(listener.verdict(counted({.framing = bytes / 3})), Verdict::kWrongBaud);
  EXPECT_EQ(listener.verdict(counted({.framing = bytes / 50})), Verdict::kNoisy);
  EXPECT_EQ(listener.verdict(counted({})), Verdict::kNoAutopilot);
  EXPECT_EQ(listener.verdict(counted({.framing = bytes, .breaks = bytes})), Verdict::kLineHeldLow);
  EXPECT_EQ(LineProbe{}.verdict(counted({.breaks = 1})), Verdict::kLineHeldLow);
  EXPECT_EQ(LineProbe{}.verdict(counted({})), Verdict::kNothingReceived);
  std::vector<std::byte> damaged = times(20, telemetry());
  for (std::size_t i = 100; i < damaged.size(); i += 600) {
    damaged[i] ^= std::byte{0x10};
  }
  EXPECT_EQ(after(damaged).verdict(counted({.framing = 3})), Verdict::kNoisy);
  EXPECT_EQ(after(damaged).verdict(counted({.overrun = 3})), Verdict::kOverrun);
  EXPECT_EQ(after(times(20, telemetry())).verdict(counted({.overrun = 3})), Verdict::kAutopilot) << "nothing is lost";
}

TEST(Probe, EveryVerdictButTheGoodOneHasARemedy) {
  for (const Verdict verdict :
       {Verdict::kApiNotEnabled, Verdict::kWrongBaud, Verdict::kNoAutopilot, Verdict::kNoisy, Verdict::kOverrun,
        Verdict::kLineHeldLow, Verdict::kNothingReceived, Verdict::kCannotOpen}) {
    EXPECT_FALSE(remedy(verdict).empty()) << name(verdict);
  }
  EXPECT_TRUE(remedy(Verdict::kAutopilot).empty());
}

TEST(Probe, EveryVerdictHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (unsigned verdict = 0; verdict <= static_cast<unsigned>(Verdict::kCannotOpen); ++verdict) {
    names.insert(name(static_cast<Verdict>(verdict)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(Verdict::kCannotOpen) + 1);
  EXPECT_EQ(names.count("") + names.count("unknown"), 0U);
  EXPECT_EQ(name(Verdict::kOverrun), "overrun") << "scripts read it";
}

TEST(Probe, TellsTheFirmwareByTheLayoutOfItsTelemetry) {
  EXPECT_EQ(after(times(3, telemetry())).firmware(), Firmware::kM100);
  std::vector<std::byte> old(2 + 4 + 16);  // time and attitude in the layout of firmware 2.3
  old[0] = std::byte{3};
  EXPECT_EQ(after(times(3, frame(&protocol::ids::kTelemetry, old))).firmware(), Firmware::kM100Old);
  std::vector<std::byte> other(2 + 99);
  other[0] = std::byte{0x41};
  EXPECT_EQ(after(times(3, frame(&protocol::ids::kTelemetry, other))).firmware(), Firmware::kOther);
}

}  // namespace
}  // namespace m100::companion
