// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "host_tests/lab/experiments/flight.h"
#include "host_tests/scenario/lies/happenings.h"
#include "host_tests/scenario/lies/waveform.h"

namespace m100::scenario {

/// One input of the program whose faults are searched: everything else stays true.
struct Channel {
  enum class Kind : std::uint8_t { kWave, kAutopilot, kOperator };
  std::string_view name;
  std::string_view unit;
  Kind kind = Kind::kWave;
  Sizes sizes{};
};
/// Every channel that is searched.
std::span<const Channel> channels();
/// @throws std::invalid_argument: there is none of this name.
const Channel& channel_of(std::string_view name);

/// A fault, as it is kept: the task, and what is wrong with the channel.
struct Fault {
  std::string task = "hover";
  Waveform wave;
  Happenings happenings;  ///< of the channels of words
};
/// "hover | drift 2 20 0.5 0.3 1 0 0". Errors of the text: std::invalid_argument.
std::string to_text(const Fault& fault);
Fault fault_of(const Channel& channel, const std::string& text);

/// What a fault came to.
struct Harm {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double after_s = kNever;  ///< from the fault's beginning until the ladder left its top
  double away_m = 0.0;      ///< the farthest from the same flight without the fault, until then or in kWatched_s
  double farthest_m = 0.0;  ///< until the sticks were the pilot's, or in kWatched_s
  double speed_m_s = 0.0;   ///< horizontal, when they were; 0: they were not
};
/// How long a flight is watched from its course's beginning; the tasks move from 8 s on.
inline constexpr double kWatched_s = 24.0;
inline constexpr double kEarliest_s = 1.0;
inline constexpr double kLatest_s = 12.0;

/// Flies the fault in the measured plant.
Harm harm_of(const Channel& channel, const Fault& fault, std::uint64_t seed);
/// What the search makes as large as it can: for waves the distance before anyone notices, for words, where most
/// orders are noticed at once because they are obeyed, the distance for as long as the program commands.
double score_of(const Channel& channel, const Harm& harm);

struct Found {
  Fault fault;
  Harm harm;
  int flights = 0;
};
/// A third of the flights draws faults, the others change the best few of them. Same arguments, same answer.
/// @param known a fault to begin with; one without pieces: none.
Found searched(const Channel& channel, int flights, std::uint64_t seed, const Fault& known);

}  // namespace m100::scenario
