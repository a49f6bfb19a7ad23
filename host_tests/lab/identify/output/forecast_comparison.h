// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// Compares the forecast of `m100-lab excite --json` for this axis with the result of the flight. For each effect of
/// the forecast: whether the excitation was large enough to show it (`enough`), whether it is in the final model
/// (`named`), and the standard deviation of its first parameter, forecast (size / apart_sigma) and found (the
/// interval's width over 3.92). Empty where the forecast is for another axis.
Json compare_with_forecast(const Json& forecast, const IdentifyResult& result);

std::string forecast_sentence(const Json& comparison);

}  // namespace m100::lab::identify
