// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/gains/margin_box.h"
#include "host_tests/lab/gains/tuning/tune.h"

namespace m100::lab::gains {

Json margins_json(const Margins& margins);

/// Prints the margins of the loop as flown, on every structure and on both channels. With `limits` it also prints the
/// worst margins of each structure over gain and frequency, and over the whole box. If those over gain and frequency do
/// not keep the limits, it prints how a manoeuvre can distinguish the structures.
/// @returns {"flown": {"structure": {"x": {"virtual_rc": {...}, "movement": {...}, "corners": {"virtual_rc": {...},
/// ...},
///          "box": {...}}, "y": {...}}}, "box": {the worst of all}, "controllers": {"x virtual_rc": {...}, ...}}; all
///          but the margins of the structures themselves only with `limits`
Json report_flown(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                  const MarginLimits* limits);

}  // namespace m100::lab::gains
