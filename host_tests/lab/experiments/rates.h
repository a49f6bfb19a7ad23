// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {

/// One command rate of one channel. The controller always runs at 100 Hz.
struct RateSetting {
  link::Channel channel = link::Channel::kVirtualRc;
  double rate_hz = 0.0;
  bool by_name = false;  ///< paper_100_hz: the paper's rate, which is outside the channel's window
};

/// The tracking errors at one command rate.
struct RateCost {
  RateSetting setting;
  std::vector<TaskResult> tasks;
};

/// Virtual RC at 5, 10, 25 Hz, movement control at 10, 25, 50 Hz, and both at 100 Hz by name.
const std::vector<RateSetting>& rate_settings();

/// Flies hover, step and trajectory (options.only: one of them), calm and with the fan, at each rate.
std::vector<RateCost> fly_rates(const SuiteOptions& options,
                                const std::vector<RateSetting>& settings = rate_settings());

/// Prints one line per rate: pose RMS of each task in m.
void print_rates(std::ostream& out, const std::vector<RateCost>& costs);
/// [{"channel": "virtual_rc", "rate_hz": 25, "by_name": false, "tasks": {"hover": {"calm": {...}, "wind": {...}}}},
/// ...]
nlohmann::json rates_to_json(const std::vector<RateCost>& costs);
/// Writes a self-contained page, rates.html. Errors: InputError.
void write_rates_report(const std::string& folder, const std::vector<RateCost>& costs, const std::string& about);

}  // namespace m100::lab::experiments
