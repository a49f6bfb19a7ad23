// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "host_tests/lab/gains/tune.h"

namespace m100::lab::gains {

nlohmann::json margins_json(const Margins& margins);

/// Prints the margins of the loop as it flies, on every structure and on both channels, and with `corners` what Virtual
/// RC keeps over gain and frequency +-20 % of each: which corner is the worst, and which manoeuvre would tell the
/// structures apart where one is not kept.
/// @returns {"structure": {"x": {"virtual_rc": {...}, "movement": {...}, "corners": {...}}, "y": {...}}}
nlohmann::json report_flown(const model::Vehicle& believed, const std::vector<Structure>& structures, bool corners);

}  // namespace m100::lab::gains
