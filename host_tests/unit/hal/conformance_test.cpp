// SPDX-License-Identifier: BSD-3-Clause
// Runs the checks of a board's self test (host_tests/target/self_test.cpp) against the mock and against Linux.
#include "host_tests/target/conformance.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>
#include <vector>

#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"
#include "hal/mock/manual_clock.h"
#include "hal/mock/manual_watchdog.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/ports/pty_uart.h"

namespace m100::hal {
namespace {

class Expectations final : public target::Report {
 public:
  void check(std::string_view what, bool holds) override {
    EXPECT_TRUE(holds) << what;
    failures_ += holds ? 0 : 1;
  }
  int failures() const { return failures_; }

 private:
  int failures_ = 0;
};

/// Counts failed checks, for a machine that must fail.
class Failures final : public target::Report {
 public:
  void check(std::string_view, bool holds) override { count_ += holds ? 0 : 1; }
  int count() const { return count_; }

 private:
  int count_ = 0;
};

TEST(Conformance, TheMockCablePasses) {
  ManualClock clock;
  UartPair pair{clock, 230400};
  Expectations report;
  const auto wait = [&] {
    clock.advance(std::chrono::milliseconds(1));
    return true;
  };
  target::check_cable(pair.a(), pair.b(), 256, wait, report);
  target::check_full_sender(pair.a(), pair.b(), std::vector<std::byte>(2 * Line::kSenderBytes), wait, report);
}

TEST(Conformance, ALinuxPortPasses) {
  const std::filesystem::path name = std::filesystem::temp_directory_path() / "m100_conformance";
  sim::PtyUart far(name.string());
  SerialPort port(name.string(), 230400);
  ASSERT_EQ(port.open(), core::Status::kOk);
  Expectations report;
  const auto wait = [] {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    return true;  // if bytes never come, ctest's time limit ends the test
  };
  target::check_cable(port, far, 1024, wait, report);
  target::check_full_sender(port, far, std::vector<std::byte>(1 << 20), wait, report);
}

TEST(Conformance, TheClocksPass) {
  Expectations report;
  ManualClock manual;
  target::check_clock(manual, std::chrono::milliseconds(10), report);
  MonotonicClock monotonic;
  target::check_clock(monotonic, std::chrono::milliseconds(1), report);
}

TEST(Conformance, TheMockWatchdogPassesAndResetsAtTheSecondHunger) {
  RecordProperty("promise", "R15");
  Expectations report;
  ManualClock clock;
  ManualWatchdog watchdog(clock);
  target::check_watchdog(
      watchdog, clock, [&] { return watchdog.bites(); }, report);
  EXPECT_FALSE(watchdog.has_reset());
  clock.advance(std::chrono::milliseconds(40));
  EXPECT_TRUE(watchdog.has_reset());
}

// Proves that the checks can fail: a cable that loses, doubles or damages bytes does not pass.
TEST(Conformance, ABadCableDoesNotPass) {
  for (const LineFaults& faults : {LineFaults{.drop_per_byte = 0.01}, LineFaults{.duplicate_per_byte = 0.01},
                                   LineFaults{.flip_per_bit = 0.001}, LineFaults{.parity_error_per_byte = 0.01}}) {
    ManualClock clock;
    UartPair pair{clock, 230400};
    pair.a_to_b().set_faults(faults);
    Failures report;
    int patience = 20000;  // bounds the wait for a lost byte
    const auto wait = [&] {
      clock.advance(std::chrono::milliseconds(1));
      return --patience > 0;
    };
    target::check_cable(pair.a(), pair.b(), 256, wait, report);
    EXPECT_GE(report.count(), 1);
  }
}

}  // namespace
}  // namespace m100::hal
