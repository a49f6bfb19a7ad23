// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "host_tests/lab/gains/tune.h"

namespace m100::lab::gains {

nlohmann::json margins_json(const Margins& margins);

/// Prints the margins of the loop as flown, on every structure and on both channels. With `corners` it also prints the
/// worst margins on Virtual RC over gain and frequency +-20 % of each structure, and if a limit is not kept, the
/// manoeuvre that distinguishes the structures.
/// @returns {"structure": {"x": {"virtual_rc": {...}, "movement": {...}, "corners": {...}}, "y": {...}}}
nlohmann::json report_flown(const model::Vehicle& believed, const std::vector<Structure>& structures, bool corners);

}  // namespace m100::lab::gains
