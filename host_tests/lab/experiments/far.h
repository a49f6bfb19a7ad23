// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {

/// A task in which the limits bind, so that a law that knows them should be the better one.
struct FarTask {
  std::string name;
  std::string course;         ///< companion::lay_course
  double from_s = 0.0;        ///< judged from here
  double to_s = 0.0;          ///< to here, where the flight ends
  double wind_m_s = 0.0;      ///< along +x
  double drag_per_s = 0.0;    ///< of the aircraft in it; 0: the measured one
  double fence_high_m = 0.0;  ///< along x, from the start; 0: the box is far away
};

/// Step of 10 m with 9 m/s of tail wind at a drag of 0.3 1/s; step of 30 m; square of 3 m whose minimum-jerk sides
/// reach 4 m/s; braking before the fence from 4 m/s; step of 6 m in calm air.
const std::vector<FarTask>& far_tasks();

/// How well one law did, mean of the flights that were flown.
struct FarScore {
  double overshoot_m = 0.0;  ///< farthest outside the box that the reference spans, horizontally, in the worst axis
  double iae_m_s = 0.0;      ///< integral of the absolute horizontal distance from the reference
  int stayed = 0;            ///< flights that never left the ladder's nominal and coast
  int flown = 0;             ///< flights that obtained control; none: the errors above say nothing
};

/// Of one flight. Where a fence stands in the way, the reference ends where the aircraft came to rest.
FarScore far_score(const Trace& trace, const FarTask& task);

struct FarResult {
  const FarTask* task = nullptr;
  FarScore mpc, lqr;
  int seeds = 0;
};

/// Flies every task with the exact law and with the clipped LQR: same seeds, observer, predictor, reference and limits.
std::vector<FarResult> fly_far(const SuiteOptions& options);

/// Flights of both laws that never obtained control.
int not_flown(const std::vector<FarResult>& results);

/// Both laws beside each other, and the sums.
void print_far(std::ostream& out, const std::vector<FarResult>& results);
/// {"tasks": [{"name": "...", "seeds": 0, "mpc": {"overshoot_m": 0, "iae_m_s": 0, "stayed": 0}, "lqr": {...}}],
///  "gain_overshoot": 0, "gain_iae": 0}; a gain: by which share the exact law's sum is below the other's, over the
/// tasks that both flew. Null: it was not flown. "not_flown": flights of a law that never obtained control.
nlohmann::json far_to_json(const std::vector<FarResult>& results);

}  // namespace m100::lab::experiments
