// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/experiments/results.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/prediction.h"
#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/loop/ordered_margin.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::loop {

struct LoopOptions {
  experiments::FlightPlan plan;  ///< of every flight: the plant, handed to the simulator only; the present vehicle file
  std::uint64_t seed = 1;
  int seeds = 5;           ///< flights per task and condition, before and after, in pairs
  double flight_s = 75.0;  ///< of each identification flight
  std::vector<std::string> tasks{"hover", "step", "trajectory"};
  bool keep_worse = false;  ///< keeps the new vehicle file even if it is worse as flown
  std::string log_folder;   ///< keeps the logs of the identification flights; empty: none are kept
  std::function<void(const std::string&)> progress;  ///< may be empty
};

struct LoopEvaluation {
  std::vector<experiments::TaskResult> experiments;
  identify::Prediction prediction;  ///< on a third flight, which no fit and no decision has used
};

struct LoopResult {
  model::Vehicle before_vehicle;  ///< as flown before
  LoopEvaluation before;
  LoopEvaluation after;
  companion::VehicleFile vehicle;  ///< the new vehicle file
  bool is_kept = true;  ///< false: as flown it is worse (is_worse(); LoopOptions::keep_worse), and the former one stays
  /// The old vehicle file with an input weight that keeps the ordered margins on the new model, if any does.
  OrderedLaw before_ordered;
  std::vector<experiments::TaskResult> ordered_experiments;  ///< flown with before_ordered
  std::map<std::string, identify::IdentifyResult>
      identified;  ///< by channel: roll, pitch, climb, yaw_rate, translation
  std::map<std::string, std::vector<identify::Refitted>> believed_found;  ///< by channel: every parameter of its model
  std::set<std::string> taken_over;    ///< channels that differ in the new vehicle file
  std::vector<std::string> decisions;  ///< which channel was taken over or left, and why
};

/// Flies, identifies from the logs alone, takes over the channels that predict better on a flight that no fit has seen,
/// and flies again. Each channel (an axis, or translation) is decided by itself: it must predict the second
/// identification flight better (predicts_better), give a controller (uncontrollable), and not make trial flights
/// worse. Published predictions are those of a third flight.
LoopResult close_loop(const LoopOptions& options);

/// One identification flight with options.plan.vehicle on excitation(seed), and its log in `file`. Errors: InputError.
FlownLog fly_and_log(const LoopOptions& options, std::uint64_t seed, const std::string& file);
/// The part of a flight's log that was flown under control, without its first second and its last 0.3 s.
identify::Range flown(const FlownLog& flight);
/// Flies the tasks in calm and in windy air with a vehicle file and consecutive seeds.
std::vector<experiments::TaskResult> fly_tasks(const LoopOptions& options, const companion::VehicleFile& vehicle,
                                               std::uint64_t seed, const std::vector<std::string>& tasks, int seeds);

/// Why no controller can be made from a vehicle file; empty: one can. A found model may be true and still not flyable.
std::string uncontrollable(const model::Vehicle& vehicle);

/// Pose RMS of the trajectory task over the cells (task and condition) that diverged neither before nor after, and the
/// names of all cells that diverged.
struct TrajectoryErrors {
  double before_m = 0.0;
  double after_m = 0.0;
  int cells = 0;  ///< of the trajectory; 0: it was not flown, or all its cells diverged
  std::vector<std::string> diverged;
};
TrajectoryErrors trajectory_errors(const LoopResult& result);

}  // namespace m100::lab::loop
