// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/semihosting.h"
#include "host_tests/golden/flight/flight_recording.h"
#include "host_tests/property/protocol/densest_autopilot_headers.h"

// Plays a recording, a file of the emulator's host, into the flight program.
namespace m100::target {

/// The most bytes that the program takes from a 921600 baud line in one tick.
inline constexpr std::size_t kHostileBytes = link::SerialLink::kBatchBytes;

/// What the program takes in one tick from a pose line of 921600 baud, ten bits a byte: the line carries more than the
/// interrupt's ring holds, and the rest is lost.
inline constexpr std::size_t kHostilePoseBytes =
    std::min<std::size_t>(921'600 * core::kTickPeriod / std::chrono::seconds(10), hal::CmsdkUart::kReceiveBytes);

/// Damaged bytes that burden the parser of the autopilot's line, in turn: only start bytes; the densest headers; noise.
inline std::byte hostile_byte(std::size_t tick, std::size_t at) {
  static std::uint32_t noise = 1;
  switch (tick % 3) {
    case 0:
      return std::byte{0xAA};
    case 1:
      return host_tests::densest_autopilot_byte(at);
    default:
      noise = noise * 1664525U + 1013904223U;
      return static_cast<std::byte>(noise >> 24U);
  }
}

/// Headers of a known MAVLink message, every third byte, each with a claim of 17 bytes: benchmark.worst_mavlink_stream
/// finds bytes that cost 7 % more, but their claims would cover the poses that the flight needs.
inline std::byte hostile_pose_byte(std::size_t at) {
  constexpr std::array<std::uint8_t, 3> kHeaders{0xFE, 9, 0};
  return static_cast<std::byte>(kHeaders[at % kHeaders.size()]);
}
inline constexpr std::size_t kHostileClaim = 17;

/// Fills what a line brings in this tick up to `size` bytes: first hostile ones, then zeros, then the recorded ones.
template <typename HostileByte>
std::uint16_t put_hostile_bytes_first(std::span<std::byte> bytes, std::size_t recorded, std::size_t size,
                                      std::size_t zeros, HostileByte&& hostile) {
  const std::size_t more = recorded < size ? size - recorded : 0;
  std::copy_backward(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(recorded),
                     bytes.begin() + static_cast<std::ptrdiff_t>(recorded + more));
  for (std::size_t i = 0; i < more; ++i) {
    bytes[i] = i + zeros < more ? hostile(i) : std::byte{0};
  }
  return static_cast<std::uint16_t>(recorded + more);
}

inline void put_hostile_bytes_first(golden::RecordedTick& tick, std::size_t number) {
  tick.head.autopilot_bytes = put_hostile_bytes_first(tick.autopilot, tick.head.autopilot_bytes, kHostileBytes, 0,
                                                      [number](std::size_t at) { return hostile_byte(number, at); });
  tick.head.pose_bytes =
      put_hostile_bytes_first(tick.pose, tick.head.pose_bytes, kHostilePoseBytes, kHostileClaim, hostile_pose_byte);
}

/// Calls on_tick(number) for each tick of the recording; it must run one tick of the flight.
/// @param hostile once the program is in control, fills each tick up to kHostileBytes and kHostilePoseBytes with bytes
///   that are damaged, before the recorded ones, and replaces the course by moves so far and so frequent that the
///   quadratic programs are at their limits
/// @returns the number of ticks; 0: no such file.
template <typename T, typename S, typename OnTick>
std::size_t play(golden::ReplayedFlight<T, S>& flight, std::string_view path, bool hostile, OnTick&& on_tick) {
  static golden::RecordedTick tick;
  hal::HostFile file(path);
  if (!file.is_open()) {
    return 0;
  }
  if (hostile) {
    flight.fly_far_and_often();
  }
  std::size_t ticks = 0;
  while (golden::read_tick(tick, [&file](std::span<std::byte> into) { return file.read(into).size(); })) {
    if (hostile && flight.controller().link().authority().in_control) {
      put_hostile_bytes_first(tick, ticks);
    }
    flight.load(tick);
    on_tick(ticks);
    flight.drain();
    ++ticks;
  }
  return ticks;
}

}  // namespace m100::target
