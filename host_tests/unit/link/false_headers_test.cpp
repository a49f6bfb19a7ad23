// SPDX-License-Identifier: BSD-3-Clause
// Twelve bytes with a valid header checksum that begin no frame: the link must not wait for the rest.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "host_tests/sim/ports/link_bench.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::link {
namespace {

using safety::AuthorityStage;
using sim::LinkBench;
using std::chrono::milliseconds;

/// The header of a frame with the length `claimed`.
std::vector<std::byte> header_of(std::size_t claimed) {
  const protocol::MessageId id = protocol::ids::kTelemetry;
  std::array<std::byte, protocol::kMaxFrameBytes> space{};
  const std::vector<std::byte> value(claimed - protocol::kFrameOverheadBytes - 2);
  const auto frame = protocol::encode_frame({.session = 0, .sequence = 7}, &id, value, space, nullptr);
  EXPECT_EQ(frame->size(), claimed);
  return {frame->begin(), frame->begin() + protocol::kHeaderBytes};
}

class FalseHeaders : public ::testing::TestWithParam<std::tuple<std::size_t, Channel>> {
 protected:
  FalseHeaders() : bench_(LinkBench::over(std::get<1>(GetParam()))) {}
  /// One tick, with a false header on the line every tenth of a second.
  void tick() {
    if (++ticks_ % 10 == 0) {
      ASSERT_EQ(bench_.cable().b().write(header_).value(), header_.size());
    }
    bench_.tick();
    if (bench_.link.authority().in_control) {
      oldest_ = std::max(oldest_, bench_.link.health().telemetry_age);
    }
  }
  LinkBench bench_;
  const std::vector<std::byte> header_ = header_of(std::get<0>(GetParam()));
  int ticks_ = 0;
  core::Duration oldest_{0};
};
INSTANTIATE_TEST_SUITE_P(Link, FalseHeaders,
                         ::testing::Combine(::testing::Values(24U, 100U, 144U, 160U, 161U, 500U, 1023U),
                                            ::testing::Values(Channel::kVirtualRc, Channel::kMovement)),
                         [](const auto& tested) {
                           return "Of" + std::to_string(std::get<0>(tested.param)) +
                                  (std::get<1>(tested.param) == Channel::kMovement ? "Movement" : "VirtualRc");
                         });

TEST_P(FalseHeaders, DoNotEndControlAndALossIsSeenAsSoonAsEver) {
  RecordProperty("promise", "R2,R4");
  ASSERT_TRUE(bench_.run_until(AuthorityStage::kReady));
  bench_.link.request_control(bench_.clock.now());
  for (int i = 0; i < 600; ++i) {
    tick();
  }
  ASSERT_EQ(bench_.link.authority().stage, AuthorityStage::kInControl);
  for (int i = 0; i < 2000; ++i) {
    tick();
    ASSERT_TRUE(bench_.link.authority().in_control) << safety::name(bench_.link.authority().reason);
  }
  EXPECT_LE(oldest_, milliseconds(40)) << "telemetry is stale at 100 ms";
  bench_.autopilot.set_mode(sim::N1Mode::kP);
  for (int i = 0; i < 100; ++i) {
    tick();
  }
  EXPECT_FALSE(bench_.link.authority().in_control);
  EXPECT_LE(bench_.autopilot.record().latest_after_loss.count(), bench_.link.command_period().count());
}

}  // namespace
}  // namespace m100::link
