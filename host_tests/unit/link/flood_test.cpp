// SPDX-License-Identifier: BSD-3-Clause
// How much a tick reads from a port that holds more than one batch, after a stall or from a device that never stops.
#include <gtest/gtest.h>

#include <algorithm>

#include "firmware/link/serial_link.h"

namespace m100::link {
namespace {

using std::chrono::milliseconds;

/// A port in which `waiting` bytes wait, none of which begins a frame.
class Flood final : public hal::Uart {
 public:
  explicit Flood(std::size_t waiting) : waiting_(waiting) {}
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const std::size_t count = std::min(destination.size(), waiting_);
    std::fill_n(destination.begin(), count, std::byte{0x55});
    waiting_ -= count;
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return source.size(); }
  std::size_t waiting() const { return waiting_; }

 private:
  std::size_t waiting_;
};

// Catches a link that reads one batch per tick: after a stall it would fly on old telemetry for as many ticks as
// batches wait.
TEST(Flood, OfSomeBatchesIsReadInOneTick) {
  Flood uart(3 * SerialLink::kBatchBytes);
  SerialLink link(uart, {});
  (void)link.receive(core::TimePoint(milliseconds(10)));
  EXPECT_EQ(uart.waiting(), 0U);
  EXPECT_EQ(link.health().bytes_received, 3 * SerialLink::kBatchBytes);
}

// Catches a link that reads while there are bytes: the tick would never end.
TEST(Flood, WithoutAnEndTakesNoMoreThanItsShareOfATick) {
  constexpr std::size_t kShare = 16 * 65536;
  Flood uart(3 * kShare);
  SerialLink link(uart, {});
  (void)link.receive(core::TimePoint(milliseconds(10)));
  EXPECT_EQ(uart.waiting(), 2 * kShare);
  (void)link.receive(core::TimePoint(milliseconds(20)));
  EXPECT_EQ(uart.waiting(), kShare);
}

}  // namespace
}  // namespace m100::link
