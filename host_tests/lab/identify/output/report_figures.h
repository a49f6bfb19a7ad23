// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::identify {

/// Adds the figures for a specialist: the cross-correlation of the residual with the input, spectra, and the frequency
/// response of the data and of both models with its coherence, for each direction of the result. Uses the series
/// "input", "measured", "declared" and "final" with their residuals; a direction without "input" is left out.
void specialist_figures(plot::Page& page, const IdentifyResult& result);

/// Adds what the final model leaves, against the channels that predict most of it on unseen data: the first curves of a
/// verdict "unexplained", otherwise those that predict more than chance. @param unit  of the response
void remainder_figures(plot::Page& page, const IdentifyResult& result, const std::string& unit);

/// The curve in words.
std::string described(const RemainderCurve& curve);

/// The series of a result by its name; null: there is none of this name.
const Series* series_named(const IdentifyResult& result, const std::string& name);

}  // namespace m100::lab::identify
