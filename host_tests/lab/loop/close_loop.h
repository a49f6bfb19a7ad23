// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
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
  std::string log_folder;  ///< keeps the logs of the identification flights; empty: none are kept
  std::function<void(const std::string&)> progress;  ///< may be empty
};

struct Side {
  std::vector<experiments::TaskResult> experiments;
  Prediction prediction;  ///< on a third flight, which no fit and no decision has seen
};

struct LoopResult {
  Side before;
  Side after;
  companion::VehicleFile vehicle;  ///< the new belief
  std::map<std::string, identify::IdentifyResult>
      identified;  ///< by channel: roll, pitch, climb, yaw_rate, translation
  std::map<std::string, std::vector<identify::Refitted>> believed_found;  ///< by channel: every parameter of its model
  std::set<std::string> taken_over;    ///< channels that the new vehicle file has new
  std::vector<std::string> decisions;  ///< which channel was taken over or left, and why
};

/// Flies, identifies from the logs alone, believes what predicts better on a flight that the fit has not seen, flies
/// again. Everything that the vehicle file says is declared, so that only what it lacks is called missing. Each channel
/// (an axis, or translation) is decided by itself: its error 1 s ahead on the second identification flight must be at
/// least 15 % smaller, gain tables can be made of it, and trial flights must not be worse with it (trial seeds are not
/// those of the tables). A cell that diverges before and after is reported and vetoes nothing. Predictions are quoted
/// on a third flight.
LoopResult close_loop(const LoopOptions& options);

/// Why no controller can be made of a vehicle file; empty: one can. What was found may be true and still not flyable.
std::string uncontrollable(const model::Vehicle& vehicle);

/// What the new vehicle file predicts worse than the old one 1 s ahead on the third flight, by more than 2 %;
/// sentences.
std::vector<std::string> predicted_worse(const LoopResult& result);

/// Pose RMS of the trajectory task over the cells that diverged neither before nor after, and the names of all cells
/// that did.
struct TrajectoryErrors {
  double before_m = 0.0;
  double after_m = 0.0;
  int cells = 0;  ///< of the trajectory; none: it was not flown, or no cell ended near its reference
  std::vector<std::string> diverged;
};
TrajectoryErrors trajectory_errors(const LoopResult& result);

/// Two numbers in a printf format, at most 127 characters.
std::string two_numbers(const char* format, double a, double b);

nlohmann::json to_json(const LoopResult& result);
void print(std::ostream& out, const LoopResult& result);
/// A self-contained page: what was found, predictions and tracking before and after. Errors: InputError.
void write_page(const LoopResult& result, const std::string& file);

}  // namespace m100::lab::loop
