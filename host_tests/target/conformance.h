// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/clock.h"
#include "hal/uart.h"
#include "hal/watchdog.h"

namespace m100::target {

// Checks that the hal of every machine must pass. They run on the PC against the mock and Linux, and on a board against
// its registers. No heap, no exceptions, no recursion.

/// Receives the results.
class Report {
 public:
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;
  virtual void check(std::string_view what, bool holds) = 0;

 protected:
  Report() = default;
  ~Report() = default;
};

/// One direction of a cable. The bytes form a pseudo-random sequence, so that a lost or doubled byte shows.
class Direction {
 public:
  Direction(hal::Uart& from, hal::Uart& to, std::uint32_t seed) : from_(from), to_(to), sent_(seed), wanted_(seed) {}

  /// Sends as much as fits, at most `ahead` bytes more than have arrived, and reads what has arrived.
  void step(std::size_t most, std::size_t ahead) {
    while (written_ < most && written_ - read_ < ahead) {
      const std::byte value = static_cast<std::byte>(sent_ >> 24U);
      if (from_.write({&value, 1}).value_or(0) == 0) {
        break;
      }
      sent_ = next(sent_);
      ++written_;
    }
    std::array<std::byte, 64> piece{};
    const std::size_t count = to_.read(piece).value_or(0);
    for (const std::byte value : std::span(piece).first(count)) {
      good_ = value == static_cast<std::byte>(wanted_ >> 24U) && good_;
      wanted_ = next(wanted_);
    }
    read_ += count;
  }
  std::size_t read() const { return read_; }
  bool good() const { return good_ && read_ == written_; }

 private:
  static std::uint32_t next(std::uint32_t state) { return state * 1664525U + 1013904223U; }

  hal::Uart& from_;
  hal::Uart& to_;
  std::uint32_t sent_;
  std::uint32_t wanted_;
  std::size_t written_ = 0;
  std::size_t read_ = 0;
  bool good_ = true;
};

/// @returns true if the receiver has counted no error, or cannot count.
inline bool is_clean(const hal::Uart& uart) {
  return uart.line_errors().value_or(hal::LineErrors{}) == hal::LineErrors{};
}

/// Checks two UARTs that are joined by a cable; no byte may be on its way.
/// @param ahead bytes that may be on their way: half of the smaller ring.
/// @param wait lets a little time pass; returns false when it has waited long enough.
template <typename Wait>
void check_cable(hal::Uart& a, hal::Uart& b, std::size_t ahead, Wait wait, Report& report) {
  constexpr std::size_t kBytes = 4096;
  std::array<std::byte, 16> piece{};
  report.check("a quiet line reads as nothing", a.read(piece).value_or(1) == 0 && b.read(piece).value_or(1) == 0);
  report.check("nothing to read into and nothing to write are allowed",
               a.read({}).value_or(1) == 0 && a.write({}).value_or(1) == 0);
  Direction there(a, b, 1);
  Direction back(b, a, 2);
  while ((there.read() < kBytes || back.read() < kBytes) && wait()) {
    there.step(kBytes, ahead);
    back.step(kBytes, ahead);
  }
  report.check("4096 bytes arrive once, in order, there", there.read() == kBytes && there.good());
  report.check("and at the same time back", back.read() == kBytes && back.good());
  report.check("the receivers have counted no error", is_clean(a) && is_clean(b));
}

/// Writes to a full sender: it must take a part, then nothing, never block, and take bytes again when there is room.
/// @param piece more than the sender holds.
template <typename Wait>
void check_full_sender(hal::Uart& a, hal::Uart& b, std::span<const std::byte> piece, Wait wait, Report& report) {
  const std::size_t taken = a.write(piece).value_or(0);
  report.check("a full sender takes a part", taken > 0 && taken < piece.size());
  std::array<std::byte, 64> got{};
  std::size_t read = 0;
  while (read < taken && wait()) {
    read += b.read(got).value_or(0);
  }
  report.check("and what it took arrives, no more and no less", read == taken && b.read(got).value_or(1) == 0);
  report.check("then it takes bytes again", a.write(piece.first(1)).value_or(0) == 1);
  while (b.read(got).value_or(0) == 0 && wait()) {
  }
}

/// @param step the unit of the sleeps: the clock's own period, or a few of them.
inline void check_clock(hal::Clock& clock, core::Duration step, Report& report) {
  constexpr int kSteps = 10;
  const core::TimePoint start = clock.now();
  bool forwards = true;
  bool late_enough = true;
  core::TimePoint last = start;
  for (int i = 1; i <= kSteps; ++i) {
    clock.sleep_until(start + i * step);
    const core::TimePoint now = clock.now();
    late_enough = now >= start + i * step && late_enough;
    forwards = now >= last && clock.now() >= now && forwards;
    last = clock.now();
  }
  report.check("the clock never runs back", forwards);
  report.check("sleep_until never ends before its deadline", late_enough);
  const core::TimePoint before = clock.now();
  clock.sleep_until(start);
  report.check("a deadline that has passed is no deadline", clock.now() >= before);
}

/// @param bites returns how often the watchdog has interrupted the program so far; its handler must feed it.
template <typename Bites>
void check_watchdog(hal::Watchdog& watchdog, hal::Clock& clock, Bites bites, Report& report) {
  constexpr core::Duration kPatience = std::chrono::milliseconds(20);
  constexpr int kPeriods = 15;
  watchdog.start(kPatience);
  core::TimePoint next = clock.now();
  for (int i = 0; i < kPeriods; ++i) {
    next += kPatience / 5;
    clock.sleep_until(next);
    watchdog.feed();
  }
  report.check("a watchdog that is fed is silent", bites() == 0);
  clock.sleep_until(clock.now() + kPatience + kPatience / 2);
  report.check("one that is not fed interrupts", bites() == 1);
  watchdog.feed();
}

}  // namespace m100::target
