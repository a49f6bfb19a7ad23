// SPDX-License-Identifier: BSD-3-Clause
// What a test on a new board must run (linker/PORTING.md): exit status 0 if every check holds, 1 if one does not. UART
// 1 and UART 2 are joined by a null-modem cable; on the emulator, by a socket (run_self_test).
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/stack_paint.h"
#include "hal/cortex_m/systick_clock.h"
#include "host_tests/golden/core/maths_sweep.h"

namespace {

using namespace m100;
using golden::view;
using hal::print;

constexpr std::uint32_t kClockPeriod_us = 10000;
hal::CmsdkUart uart1(hal::mps2::uart(1), hal::mps2::set_pending(), hal::mps2::transmit_mask(1));
hal::CmsdkUart uart2(hal::mps2::uart(2), hal::mps2::set_pending(), hal::mps2::transmit_mask(2));
hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, kClockPeriod_us);

int failures = 0;

void expect(std::string_view what, bool holds) {
  print(holds ? "ok      " : "FAILED  ");
  print(what);
  print("\n");
  failures += holds ? 0 : 1;
}

void expect_equal(std::string_view what, std::string_view got, std::string_view wanted) {
  expect(what, got == wanted);
  if (got != wanted) {
    print("  got    ");
    print(got);
    print("\n  wanted ");
    print(wanted);
    print("\n");
  }
}

/// A stream of bytes that no fault leaves in step.
class Noise {
 public:
  explicit Noise(std::uint32_t seed) : state_(seed) {}
  std::byte next() {
    state_ = state_ * 1664525U + 1013904223U;
    return static_cast<std::byte>(state_ >> 24U);
  }

 private:
  std::uint32_t state_;
};

/// One direction of the cable.
class Direction {
 public:
  Direction(hal::CmsdkUart& from, hal::CmsdkUart& to, std::uint32_t seed)
      : from_(from), to_(to), sent_(seed), wanted_(seed) {}

  /// Keeps at most half of the receiver's ring on its way, both ways at once.
  void step(std::size_t most) {
    while (written_ < most && written_ - read_ < hal::CmsdkUart::kReceiveBytes / 2) {
      const std::byte value = sent_.next();
      if (from_.write({&value, 1}).value_or(0) == 0) {
        unwritten_ = true;
        break;
      }
      ++written_;
    }
    std::array<std::byte, 64> piece{};
    const std::size_t count = to_.read(piece).value_or(0);
    for (const std::byte value : std::span(piece).first(count)) {
      good_ = value == wanted_.next() && good_;
    }
    read_ += count;
  }
  std::size_t read() const { return read_; }
  bool good(std::size_t bytes) const {
    return good_ && !unwritten_ && read_ == bytes && to_.lost() == 0 && to_.received() == bytes;
  }

 private:
  hal::CmsdkUart& from_;
  hal::CmsdkUart& to_;
  Noise sent_;
  Noise wanted_;
  std::size_t written_ = 0;
  std::size_t read_ = 0;
  bool good_ = true;
  bool unwritten_ = false;
};

void test_uarts() {
  constexpr std::size_t kBytes = 4096;
  constexpr std::uint32_t kBaud = 230400;
  uart1.start(hal::mps2::kClock_hz, kBaud);
  uart2.start(hal::mps2::kClock_hz, kBaud);
  hal::mps2::enable_uart_interrupts();
  Direction there(uart1, uart2, 1);
  Direction back(uart2, uart1, 2);
  for (std::uint32_t visit = 0; visit < 20000000 && (there.read() < kBytes || back.read() < kBytes); ++visit) {
    there.step(kBytes);
    back.step(kBytes);
  }
  expect("UART 1 to UART 2: every byte, once, in order", there.good(kBytes));
  expect("UART 2 to UART 1: every byte, once, in order", back.good(kBytes));
}

void test_clock() {
  constexpr int kPeriods = 25;
  const core::TimePoint start = system_clock.now();
  core::TimePoint last = start;
  bool forwards = true;
  while (last - start < kPeriods * core::Duration(kClockPeriod_us)) {
    const core::TimePoint now = system_clock.now();
    forwards = forwards && now >= last && now - last < core::Duration(kClockPeriod_us);
    last = now;
  }
  expect("the clock runs forwards across its periods", forwards);
  const core::TimePoint deadline = system_clock.now() + std::chrono::milliseconds(25);
  system_clock.sleep_until(deadline);
  const core::Duration late = system_clock.now() - deadline;
  expect("sleep_until ends at its deadline, not before",
         late >= core::Duration(0) && late < std::chrono::milliseconds(1));
}

/// Uses about a kilobyte of stack.
[[gnu::noinline]] std::uint32_t dig() {
  std::array<volatile std::uint32_t, 256> deep;
  for (volatile std::uint32_t& word : deep) {
    word = 1;
  }
  return deep[0] + deep[255];
}

void test_stack() {
  const std::uint32_t before = hal::deepest_stack_bytes();
  const bool dug = dig() == 2;
  const std::uint32_t after = hal::deepest_stack_bytes();
  print("stack: ");
  print(std::int64_t{after});
  print(" of ");
  print(std::int64_t{hal::reserved_stack_bytes()});
  print(" bytes\n");
  expect("the paint shows how deep the stack was", dug && before > 0 && after >= 1024 && after >= before);
  expect("half of the stack is free", after <= hal::reserved_stack_bytes() / 2);
}

}  // namespace

extern "C" {
void SysTick_Handler() { system_clock.on_period(); }
void Uart1Rx_Handler() { uart1.on_receive(); }
void Uart1Tx_Handler() { uart1.on_transmit(); }
void Uart2Rx_Handler() { uart2.on_receive(); }
void Uart2Tx_Handler() { uart2.on_transmit(); }
}

int main() {
  using namespace m100::golden;
  system_clock.start();
  expect_equal("maths in double has the bits of every other machine", view(maths_sweep<double>(kSweepRounds)),
               kSweepOfDouble);
  expect_equal("maths in float has the bits of every other machine", view(maths_sweep<float>(kSweepRounds)),
               kSweepOfFloat);
  test_stack();
  test_clock();
  test_uarts();
  return failures == 0 ? 0 : 1;
}
