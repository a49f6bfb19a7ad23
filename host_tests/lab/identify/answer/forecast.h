// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host_tests/lab/identify/answer/result.h"

namespace m100::lab::identify {

/// What `m100-lab excite --json` said before the flight about this axis, beside what was then found in it. For each
/// effect of the forecast: whether it was to show (`enough`), whether it is in the final model (`named`), and the
/// standard deviation of its first number, forecast (size / apart_sigma) and found (the interval's quarter width).
/// Empty where the forecast is about another axis.
nlohmann::ordered_json compare_with_forecast(const nlohmann::json& forecast, const IdentifyResult& result);

/// The comparison in one sentence.
std::string forecast_sentence(const nlohmann::ordered_json& comparison);

}  // namespace m100::lab::identify
