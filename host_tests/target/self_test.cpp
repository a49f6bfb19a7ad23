// SPDX-License-Identifier: BSD-3-Clause
// Self test that a new board must pass before it flies (linker/PORTING.md). It prints to the board's UART 0: a line for
// each check, and "PASSED n" or "FAILED m of n" at the end. It needs no debugger, no emulator and no file. UART 1 and
// UART 2 must be joined by a null-modem cable, or on the emulator by a socket (run_self_test).
#include <array>
#include <charconv>
#include <cstdint>
#include <span>
#include <string_view>

#include M100_BOARD_HEADER  // Deviation: the board decides; linker/image.cmake names the header

#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/cmsdk_watchdog.h"
#include "hal/cortex_m/stack_paint.h"
#include "hal/cortex_m/systick_clock.h"
#include "host_tests/golden/core/maths_sweep.h"
#include "host_tests/target/conformance.h"

namespace {

using namespace m100;
using golden::view;
namespace board = hal::board;

constexpr std::uint32_t kClockPeriod_us = 10000;
constexpr std::uint32_t kConsoleBaud = 115200;
constexpr std::uint32_t kBaud = 230400;
hal::CmsdkUart console(board::uart(0), board::set_pending(), board::transmit_mask(0));
hal::CmsdkUart uart1(board::uart(1), board::set_pending(), board::transmit_mask(1));
hal::CmsdkUart uart2(board::uart(2), board::set_pending(), board::transmit_mask(2));
hal::SysTickClock system_clock(board::systick(), board::kClock_hz, kClockPeriod_us);
hal::CmsdkWatchdog watchdog(board::watchdog(), board::watchdog_lock(), board::kClock_hz);
volatile std::uint32_t bites = 0;

/// Waits for room in the sender, because no result may be lost and nothing else runs meanwhile.
void print(std::string_view text) {
  std::span<const std::byte> rest = std::as_bytes(std::span(text));
  while (!rest.empty()) {
    rest = rest.subspan(console.write(rest).value_or(0));
  }
}

void print(std::uint32_t number) {
  std::array<char, 12> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  print(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

class Results final : public target::Report {
 public:
  void check(std::string_view what, bool holds) override {
    print(holds ? "ok      " : "FAILED  ");
    print(what);
    print("\n");
    ++checks_;
    failures_ += holds ? 0U : 1U;
  }
  void check_equal(std::string_view what, std::string_view got, std::string_view wanted) {
    check(what, got == wanted);
    if (got != wanted) {
      print("  got    ");
      print(got);
      print("\n  wanted ");
      print(wanted);
      print("\n");
    }
  }
  void print_sum() const {
    print(failures_ == 0 ? "PASSED " : "FAILED ");
    if (failures_ > 0) {
      print(failures_);
      print(" of ");
    }
    print(checks_);
    print("\n");
  }

 private:
  std::uint32_t checks_ = 0;
  std::uint32_t failures_ = 0;
};
Results results;

void test_uarts() {
  static constexpr std::array<std::byte, 4 * hal::CmsdkUart::kTransmitBytes> kMuch{};
  const auto go_on = [visits = 0U]() mutable { return ++visits < 20000000U; };
  target::check_cable(uart1, uart2, hal::CmsdkUart::kReceiveBytes / 2, go_on, results);
  target::check_full_sender(uart1, uart2, kMuch, go_on, results);
}

/// sleep_until() must be late by less than a millisecond, and the clock must not jump at the end of its period.
void test_clock() {
  target::check_clock(system_clock, core::Duration(kClockPeriod_us), results);
  constexpr int kPeriods = 10;
  const core::TimePoint start = system_clock.now();
  core::TimePoint last = start;
  bool smooth = true;
  while (last - start < kPeriods * core::Duration(kClockPeriod_us)) {
    const core::TimePoint now = system_clock.now();
    smooth = smooth && now - last < core::Duration(kClockPeriod_us);
    last = now;
  }
  results.check("the clock does not leap at the end of its period", smooth);
  const core::TimePoint deadline = system_clock.now() + std::chrono::milliseconds(25);
  system_clock.sleep_until(deadline);
  results.check("sleep_until ends within a millisecond of its deadline",
                system_clock.now() - deadline < std::chrono::milliseconds(1));
}

/// 64-bit integers whose conversion rounds: at ties, one beside a tie (a double does not tell the two apart), and at
/// the ends of the range.
constexpr std::int64_t kTie = ((std::int64_t{1} << 24U) + 1) << 32U;  // a tie of float
constexpr std::array<std::int64_t, 14> kSigned{
    0,         -1,        16777217,        16777219,        (std::int64_t{1} << 53U) + 1,
    kTie - 1,  kTie,      kTie + 1,        1 - kTie,        -1 - kTie,
    INT64_MAX, INT64_MIN, INT64_MAX - 511, (kTie << 6U) + 1};
constexpr std::array<std::uint64_t, 6> kUnsigned{0,
                                                 4294967296U,
                                                 (std::uint64_t{1} << 53U) + 3,
                                                 UINT64_MAX,
                                                 UINT64_MAX - (1U << 10U),
                                                 (std::uint64_t{kTie} << 7U) + 1};

/// Converts with the compiler's arithmetic at compile time; converts() compares the conversion at run time.
template <typename To, typename Wide, std::size_t kCount>
constexpr std::array<To, kCount> converted(const std::array<Wide, kCount>& numbers) {
  std::array<To, kCount> out{};
  for (std::size_t i = 0; i < kCount; ++i) {
    out[i] = static_cast<To>(numbers[i]);
  }
  return out;
}

template <typename To, const auto& kNumbers>
bool converts() {
  constexpr auto kExpected = converted<To>(kNumbers);
  bool same = true;
  for (std::size_t i = 0; i < kNumbers.size(); ++i) {
    const volatile auto number = kNumbers[i];
    same = static_cast<To>(number) == kExpected[i] && same;
  }
  return same;
}

void test_wide_integers() {
  results.check("64-bit integers become doubles, rounded once", converts<double, kSigned>());
  results.check("64-bit integers become floats, rounded once", converts<float, kSigned>());
  results.check("unsigned 64-bit integers become doubles, rounded once", converts<double, kUnsigned>());
  results.check("unsigned 64-bit integers become floats, rounded once", converts<float, kUnsigned>());
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
  print(after);
  print(" of ");
  print(hal::reserved_stack_bytes());
  print(" bytes\n");
  results.check("the paint shows how deep the stack was", dug && before > 0 && after >= 1024 && after >= before);
  results.check("half of the stack is free", after <= hal::reserved_stack_bytes() / 2);
}

}  // namespace

extern "C" {
void NMI_Handler() {
  bites = bites + 1;
  watchdog.feed();
}
void SysTick_Handler() { system_clock.on_period(); }
void Uart0Rx_Handler() { console.on_receive(); }
void Uart0Tx_Handler() { console.on_transmit(); }
void Uart1Rx_Handler() { uart1.on_receive(); }
void Uart1Tx_Handler() { uart1.on_transmit(); }
void Uart2Rx_Handler() { uart2.on_receive(); }
void Uart2Tx_Handler() { uart2.on_transmit(); }
}

/// Does not return: only an emulator could receive the result of main().
int main() {
  using namespace m100::golden;
  console.start(board::kClock_hz, kConsoleBaud);
  uart1.start(board::kClock_hz, kBaud);
  uart2.start(board::kClock_hz, kBaud);
  board::enable_uart_interrupts();
  system_clock.start();
  results.check_equal("maths in double has the bits of every other machine", view(maths_sweep<double>(kSweepRounds)),
                      kSweepOfDouble);
  results.check_equal("maths in float has the bits of every other machine", view(maths_sweep<float>(kSweepRounds)),
                      kSweepOfFloat);
  test_wide_integers();
  test_stack();
  test_clock();
  test_uarts();
  target::check_watchdog(
      watchdog, system_clock, [] { return std::uint32_t{bites}; }, results);
  results.print_sum();
  for (;;) {
    system_clock.sleep_until(system_clock.now() + core::Duration(kClockPeriod_us));
    watchdog.feed();
  }
}
