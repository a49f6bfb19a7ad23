// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// A time range [from, to) in seconds, by default on the clock of a FlightLog; joined logs have one common clock.
using Range = std::pair<double, double>;

/// The tests of a log beside the selection of effects. Each can be left out, to count the answers that it saves.
enum class SpecialTest {
  kFrozenStick,
  kClock,
  kZeroOrClock,  ///< a lead zero that a wrong clock explains loses its name
  kTether,
  kBothParts,  ///< both parts of a log settle the names
  kChange,
  kOneSide,    ///< the structure is selected again on one side of a change
  kConstant,   ///< an effect without a date is preferred to a change
  kTemporary,  ///< a change that ends again
  kSlowStick,  ///< an effect must hold whatever a slowly logged stick did between its rows
  kWeakEffect,
  kCount
};

/// The request of `m100-lab identify`, after parsing.
struct Request {
  std::string axis;                   ///< "roll", "pitch", "yaw_rate", "climb" or "translation"
  std::vector<std::string> declared;  ///< base model first, then effects
  std::vector<Range> train;
  std::vector<Range> validate;
  const logs::FlightLog* log = nullptr;             ///< the training ranges lie in it
  const logs::FlightLog* validation_log = nullptr;  ///< the validation ranges lie in it; null: in `log`
  std::vector<Range> requested{};  ///< ranges of the user's request in `log`, if `train` is only a part of them
  double noise_floor = 0.0;        ///< declared root mean square error of air and noise, in the axis' unit; 0: none
  double wind_from_first_s = 0.0;  ///< translation: each flight's wind comes from its first seconds; 0: it is fitted
  std::size_t refits = 40;         ///< maximum number of refits for the intervals; 0: no intervals
  std::function<void(const std::string&)> progress;  ///< one short line at a time; may be empty
  /// Asked when a special test is about to change the answer: whether it may. Empty: all may.
  std::function<bool(SpecialTest)> may_act;

  bool acts(SpecialTest test) const { return !may_act || may_act(test); }
};

/// Whether training and validation ranges lie in one log.
inline bool in_one_log(const Request& request) {
  return request.validation_log == nullptr || request.validation_log == request.log;
}

/// The ranges of the user's request in the log of the training part or, if not `training`, of the validation part.
inline std::vector<Range> requested_ranges(const Request& request, bool training) {
  if (!training && !in_one_log(request)) {
    return request.validate;
  }
  std::vector<Range> out = request.requested.empty() ? request.train : request.requested;
  if (request.requested.empty() && in_one_log(request)) {
    out.insert(out.end(), request.validate.begin(), request.validate.end());
  }
  return out;
}

}  // namespace m100::lab::identify
