// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::host_tests {

/// A log of which the truth is known, made to lead the identification astray: simulated, one roll axis of 45 s
/// (synthetic_axis.h), or a stranger's (stranger.h).
struct Adversary {
  std::string kind;
  lab::logs::FlightLog log;
  std::string axis = "roll";
  std::vector<std::string> declared{"second_order", "transport_delay"};
  bool healthy = false;            ///< a clean bill is the right answer
  std::string change;              ///< what changes in mid-flight; empty: nothing
  double change_s = 0.0;           ///< and when
  std::string finding;             ///< what must be found about the log; empty: nothing
  std::vector<std::string> named;  ///< effects that may be named
  std::string effect;              ///< what the declared model lacks throughout; empty: nothing
  /// A clean bill is right where the finding is said: the rest of the log is sound. A change of the air alone ("note")
  /// need not be said: the model lacks nothing.
  bool usable = false;
  std::vector<std::pair<double, double>> train{{3.0, 30.0}}, validate{{30.0, 44.0}};
  /// Bound of what the log can tell of what is hidden (stranger_bound.h); empty: anyone sees it. Costs up to a second.
  std::function<double()> evidence;
};

/// The kinds, in the order of the published table.
const std::vector<std::string>& adversary_kinds();
/// @param kind  one of adversary_kinds()
Adversary adversary(const std::string& kind, std::uint64_t seed);

enum class Answer { kRight, kUndecided, kWrongName, kFalseClean, kRefusedHealthy };

/// What the answer to an adversary is worth.
///   right         the change, the effect or the finding is named and nothing else is; healthy: a clean bill
///   undecided     "unexplained", and what was looked for is not named for certain
///   wrong name    "explained" by something that is not there
///   false clean   "nothing_missing" although something is there
///   refused       a healthy log that gets no clean bill
Answer judge(const Adversary& truth, const lab::identify::IdentifyResult& result);

/// Asks identify as the adversary says.
lab::identify::IdentifyResult ask(const Adversary& truth, std::size_t refits = 0);

}  // namespace m100::host_tests
