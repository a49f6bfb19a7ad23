// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "host_tests/lab/experiments/flight.h"
#include "host_tests/scenario/sensor_faults/command_faults.h"
#include "host_tests/scenario/sensor_faults/waveform.h"

namespace m100::scenario {

/// One input of the program, whose faults are searched while all other inputs stay true.
struct Channel {
  enum class Kind : std::uint8_t { kWave, kAutopilot, kOperator };
  std::string_view name;
  std::string_view unit;
  Kind kind = Kind::kWave;
  Sizes sizes{};
};
/// All channels of the search.
std::span<const Channel> channels();
/// @throws std::invalid_argument if there is no channel of this name.
const Channel& channel_of(std::string_view name);

/// A fault as worst_faults.txt keeps it: the task and the fault of the channel.
struct Fault {
  std::string task = "hover";
  Waveform wave;
  CommandFaults command_faults;  ///< for the operator's and the autopilot's channel
};
/// Text form: "hover | drift 2 20 0.5 0.3 1 0 0". @throws std::invalid_argument for a malformed text.
std::string to_text(const Fault& fault);
Fault fault_of(const Channel& channel, const std::string& text);

/// The effect of a fault.
struct FaultEffect {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double after_s = kNever;  ///< from the fault's beginning until the failsafe left its top
  double away_m = 0.0;      ///< largest distance from the flight without the fault, until after_s or kWatched_s
  double farthest_m = 0.0;  ///< largest distance until the pilot had the sticks, or until kWatched_s
  double went_on_m = 0.0;   ///< from its place after after_s until the pilot had the sticks
  double speed_m_s = 0.0;   ///< horizontal, when the pilot got the sticks; 0 if never
};
/// How long a flight is watched after its course began; the tasks begin to move at 8 s.
inline constexpr double kObserved_s = 24.0;
inline constexpr double kEarliest_s = 1.0;
inline constexpr double kLatest_s = 12.0;

/// Flies the fault in the measured plant.
FaultEffect effect_of(const Channel& channel, const Fault& fault, std::uint64_t seed);
/// The score that the search maximises. For waveforms it is the distance until the fault is noticed. For orders and
/// answers it is the distance while the program commands, because most orders are obeyed and so noticed at once.
double score_of(const Channel& channel, const FaultEffect& effect);

struct SearchResult {
  Fault fault;
  FaultEffect effect;
  int flights = 0;
};
/// Searches: a third of the flights draw faults, the others vary the best few. Same arguments give the same answer.
/// @param known a fault to begin with; a fault without pieces means none.
SearchResult run_search(const Channel& channel, int flights, std::uint64_t seed, const Fault& known);

}  // namespace m100::scenario
