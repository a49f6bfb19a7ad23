// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Seconds [from, to) on the log's own clock.
using Range = std::pair<double, double>;

/// What `m100-lab identify` was asked, after parsing.
struct Request {
  std::string axis;                   ///< "roll", "pitch", "yaw_rate", "climb" or "translation"
  std::vector<std::string> declared;  ///< base model first, then effects
  std::vector<Range> train;
  std::vector<Range> validate;
  const logs::FlightLog* log = nullptr;             ///< the training ranges lie in it
  const logs::FlightLog* validation_log = nullptr;  ///< the validation ranges lie in it; may be the same
  double noise_floor = 0.0;                         ///< declared; 0: none
  std::size_t bootstrap_draws = 200;
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress;  ///< one short line at a time; may be empty
};

/// One of the stick axes. @throws InputError: missing signal, axis never moved, too few blocks, unknown effect.
IdentifyResult identify_axis(const Request& request);

/// Horizontal translation. @throws InputError as above.
IdentifyResult identify_translation(const Request& request);

}  // namespace m100::lab::identify
