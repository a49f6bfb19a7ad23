// SPDX-License-Identifier: BSD-3-Clause
// Repeated telemetry says nothing about the present: only new telemetry may complete a release (promise R15).
#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <vector>

#include "host_tests/sim/ports/link_bench.h"
#include "protocol/dji/frame_parser.h"

namespace m100::link {
namespace {

using safety::AuthorityStage;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// One end of a line that can freeze telemetry: answers pass, but telemetry repeats one frame.
class FreezingLine final : public hal::Uart {
 public:
  explicit FreezingLine(hal::Uart& line) : line_(line) {}
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    std::array<std::byte, 512> came;
    const auto count = line_.read(came);
    parser_.consume(std::span(came).first(count.value_or(0)), [this](const protocol::FrameView& frame) {
      const std::vector<std::byte> bytes(frame.bytes.begin(), frame.bytes.end());
      const bool is_telemetry = !frame.header.is_ack && frame.header.session == 0;
      frozen_ = is_telemetry && (!is_frozen || frozen_.empty()) ? bytes : frozen_;
      const std::vector<std::byte>& passed = is_telemetry ? frozen_ : bytes;
      waiting_.insert(waiting_.end(), passed.begin(), passed.end());
    });
    const std::size_t taken = std::min(destination.size(), waiting_.size());
    std::copy_n(waiting_.begin(), taken, destination.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(taken));
    return taken;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override {
    return loses_what_is_sent ? source.size() : line_.write(source);
  }
  bool is_frozen = false;
  bool loses_what_is_sent = false;

 private:
  hal::Uart& line_;
  protocol::FrameParser parser_;
  std::vector<std::byte> frozen_;
  std::deque<std::byte> waiting_;
};

class FrozenTelemetry : public ::testing::TestWithParam<Channel> {
 protected:
  FrozenTelemetry() { bench_.commanding = false; }
  sim::LinkBench::Options options() {
    sim::LinkBench::Options options = sim::LinkBench::over(GetParam());
    options.line = [this](hal::Uart& end) -> hal::Uart& { return line_.emplace(end); };
    return options;
  }
  std::optional<FreezingLine> line_;
  sim::LinkBench bench_{options()};
};
INSTANTIATE_TEST_SUITE_P(Link, FrozenTelemetry, ::testing::Values(Channel::kVirtualRc, Channel::kMovement),
                         [](const auto& tested) {
                           return tested.param == Channel::kVirtualRc ? "VirtualRc" : "Movement";
                         });

// Catches a client that believes that the transmitter has control because it keeps receiving a frame from before the
// grant.
TEST_P(FrozenTelemetry, OfATimeBeforeTheGrantFinishesNoRelease) {
  RecordProperty("promise", "R15");
  bench_.run(seconds(5));
  ASSERT_EQ(bench_.link.authority().stage, AuthorityStage::kReady);
  line_->is_frozen = true;
  bench_.link.request_control(bench_.clock.now());
  bench_.run(milliseconds(100));
  line_->loses_what_is_sent = true;  // the first releases are lost; later ones must succeed
  bench_.run(seconds(3));
  EXPECT_TRUE(bench_.link.authority().release_pending) << "nothing new has said that the transmitter has it";
  EXPECT_FALSE(bench_.link.authority().telemetry_fresh);
  EXPECT_FALSE(bench_.link.authority().link_alive) << "a repeated frame is no sign of life";
  EXPECT_GT(bench_.link.health().old_packages, 200U);
  EXPECT_LT(bench_.link.health().old_packages, 400U);
  line_->loses_what_is_sent = false;
  bench_.run(seconds(1));
  EXPECT_FALSE(bench_.autopilot.client_in_control());
  EXPECT_TRUE(bench_.link.authority().release_pending) << "and still nobody has said so";
  line_->is_frozen = false;
  bench_.run(milliseconds(100));
  EXPECT_FALSE(bench_.link.authority().release_pending);
  EXPECT_EQ(bench_.link.authority().stage, AuthorityStage::kSilentCold) << "never by itself";
}

}  // namespace
}  // namespace m100::link
