// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/experiments/results.h"
#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/loop/prediction.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::loop {

struct LoopOptions {
  sim::Plant plant;                ///< handed to the simulator only
  companion::VehicleFile vehicle;  ///< present belief
  std::uint64_t seed = 1;
  int seeds = 1;           ///< flights per cell of the tables before and after
  double flight_s = 75.0;  ///< of each identification flight
  mpc::Law law = mpc::Law::kMpc;
  std::vector<std::string> tasks{"hover", "step", "trajectory"};
  std::string work_folder = "/tmp";
  std::function<void(const std::string&)> progress;  ///< may be empty
};

struct Side {
  std::vector<experiments::TaskResult> experiments;
  Prediction prediction;  ///< on the second identification flight, which no fit has seen
};

struct LoopResult {
  Side before;
  Side after;
  companion::VehicleFile vehicle;  ///< the new belief
  std::map<std::string, identify::IdentifyResult> identified;
  std::vector<std::string> decisions;  ///< which axis was taken over or left, and why
};

/// Flies, identifies from the logs alone, believes what predicts better on a flight that the fit has not seen, flies
/// again. An axis is taken over only if its 2.5 s simulation error on the second flight is at least 2 % smaller; the
/// translation likewise, by the 1 s prediction of the velocity. The
/// whole is kept only if a trial flight tracks no worse than before (trial seeds are not those of the tables).
LoopResult close_loop(const LoopOptions& options);

/// Pose RMS of the trajectory task, calm and windy together.
double trajectory_error_m(const std::vector<experiments::TaskResult>& results);

nlohmann::json to_json(const LoopResult& result);
void print(std::ostream& out, const LoopResult& result);
/// A self-contained page: what was found, predictions and tracking before and after. Errors: InputError.
void write_page(const LoopResult& result, const std::string& file);

}  // namespace m100::lab::loop
