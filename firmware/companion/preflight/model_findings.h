// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/fly.h"

namespace m100::companion {

/// One point on which vehicle file, table and the program's limits must agree. `m100 check` prints each; `fly` refuses
/// a finding that does not hold, unless --override names it.
struct ConsistencyFinding {
  std::string_view name;  ///< for --override; empty: it always holds, because otherwise an error came before
  bool holds = false;
  std::string what;
};
std::vector<ConsistencyFinding> findings(const FlightModel& model);

/// The names that --override takes: the consistency checks in flight, except height, and the findings.
std::vector<std::string> names_for_override();

/// Loads the vehicle and the tables that the options name. Errors: UsageError, also if one of findings() does not hold
/// and --override does not name it.
FlightModel sound_model(const FlyOptions& options, Mode mode);

}  // namespace m100::companion
