// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/companion/files/recorded_flight.h"
#include "firmware/companion/replay/flight_notes.h"
#include "firmware/core/sha256.h"
#include "protocol/cipher.h"

namespace m100::app {
template <typename T, typename S>
class FlightController;
}  // namespace m100::app

namespace m100::companion {

/// The arithmetic of the flight code; kFixed: the observer in fixed point, the rest in float.
enum class Scalar : std::uint8_t { kDouble, kFloat, kFixed };

struct ReplayResult {
  core::Sha256Digest digest{};  ///< over the bytes to the autopilot and the log::TickRecord of every tick, in order
  std::size_t ticks = 0;
  std::size_t different_ticks = 0;              ///< ticks whose record or output bytes differ from the log
  std::size_t first_difference = 0;             ///< the first such tick
  std::vector<std::size_t> differences;         ///< all of them
  double largest_difference_m = 0.0;            ///< of the estimated position, against the record
  double largest_command_difference_rad = 0.0;  ///< of roll and pitch as granted
  std::uint32_t messages_missing = 0;           ///< dropped by the log's ring: their bytes cannot be replayed
};

/// Feeds the recorded bytes and times to the flight code. Errors: FlightLogError, or the error of a file in its notes.
/// @param cipher of the app's key, for a flight with encrypted commands; otherwise null.
ReplayResult replay(const RecordedFlight& flight, Scalar scalar, const protocol::Cipher* cipher = nullptr);
/// Replays in double, as `m100 fly` flew.
/// @param observe called after every tick with the controller, for values that the log does not hold.
ReplayResult replay(const RecordedFlight& flight, const protocol::Cipher* cipher,
                    const std::function<void(const app::FlightController<double, double>&)>& observe);

}  // namespace m100::companion
