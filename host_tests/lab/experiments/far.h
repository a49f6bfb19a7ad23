// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {

/// A task in which the limits are active, so that a law that knows them should be better.
struct FarTask {
  std::string name;
  std::string course;         ///< companion::parse_course
  double from_s = 0.0;        ///< start of the judged window
  double to_s = 0.0;          ///< end of the judged window and of the flight
  double wind_m_s = 0.0;      ///< along +x, added to that of the plant
  double drag_per_s = 0.0;    ///< drag of the aircraft; 0: that of the plant
  double fence_high_m = 0.0;  ///< fence along x, from the start; 0: far away
};

/// Step of 10 m with 9 m/s of tail wind at a drag of 0.3 1/s; step of 30 m; square of 3 m whose minimum-jerk sides
/// reach 4 m/s; braking before the fence from 4 m/s; step of 6 m in calm air.
const std::vector<FarTask>& far_tasks();

/// The errors of one law, means over the flights that were flown, and the numbers of flights.
struct FarScore {
  double overshoot_m = 0.0;  ///< largest distance outside the box that the reference spans, on the worse axis
  double settled_s = 0.0;  ///< from the start of the window until the distance from the reference stays 2 s below 2 cm
  double iae_m_s = 0.0;    ///< integral of the absolute horizontal distance from the reference
  int stayed = 0;          ///< flights that never went below coast
  int flown = 0;           ///< flights that obtained control; 0: the errors above are invalid
};

/// The score of one flight. If a fence blocks the course, its reference in x ends where the aircraft came to rest.
FarScore far_score(const Trace& trace, const FarTask& task);

struct FarResult {
  const FarTask* task = nullptr;
  FarScore planned, mpc, lqr;
  int seeds = 0;
};

/// Flies every task with three laws: the exact MPC on planned set points, the exact MPC alone, and the clipped LQR.
/// Seeds, observer, predictor and limits are the same.
std::vector<FarResult> fly_far(const SuiteOptions& options);

/// The number of flights, of all tasks and all three laws, that never obtained control.
int not_flown(const std::vector<FarResult>& results);

/// Prints the scores of all three laws side by side, and their sums.
void print_far(std::ostream& out, const std::vector<FarResult>& results);
/// {"tasks": [{"name": "...", "seeds": 0, "mpc": {"overshoot_m": 0, "iae_m_s": 0, "settled_s": 0, "stayed": 0},
///    "lqr": {...}, "planned": {...}}],
///  "gain_overshoot": 0, "gain_iae": 0}. A gain is the share by which the sum of "mpc" is below that of "lqr",
/// over the tasks that all three laws flew. Null: not flown. Each law also has "not_flown": flights without control.
Json far_to_json(const std::vector<FarResult>& results);

}  // namespace m100::lab::experiments
