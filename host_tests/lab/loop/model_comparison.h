// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/gains/tuning/tune.h"
#include "host_tests/lab/loop/close_loop.h"
#include "host_tests/lab/paired_errors.h"

namespace m100::lab::loop {

/// A vehicle file that is flown, with its name in the table.
struct ComparedModel {
  std::string name;
  companion::VehicleFile vehicle;
};

/// Root mean squares of one model: the mean over the seeds with its 95 % interval (Student's t).
struct ModelScore {
  std::string name;
  std::map<std::string, Interval> prediction_1s;  ///< by quantity (kQuantities), 1 s ahead
  std::map<std::string, Interval> pose_m;         ///< by task, calm and windy air together
  std::map<std::string, Interval> horizontal_m;   ///< likewise
  std::vector<std::string> diverged;  ///< cells (task and condition) in which it flew away, or never obtained control
  gains::TunedMargins margins;        ///< of its law on the aircraft `truth`, the worse of both axes; computed
};

/// Flies every model on the same plant with the same seeds. The predictions are made from excitation flights that the
/// last model's law flies, one a seed, so that all models predict the same flights.
/// @param truth  the axes of options.plan.plant as a vehicle, for the margins
std::vector<ModelScore> compare_models(const LoopOptions& options, const std::vector<ComparedModel>& models,
                                       const model::Vehicle& truth);

void print(std::ostream& out, const std::vector<ModelScore>& scores);
/// [{"name", "prediction_1s": {QUANTITY: {"value", "low", "high"}}, "pose_m": {TASK: ...}, "horizontal_m": {TASK: ...},
///   "diverged": [...], "margins": {"stable", "peak_sensitivity", "delay_margin_s"}}]
Json to_json(const std::vector<ModelScore>& scores);

}  // namespace m100::lab::loop
