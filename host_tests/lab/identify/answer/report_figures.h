// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::identify {

/// What a specialist asks for beside the time histories: the residual against the input, spectra, and the frequency
/// response of the data and of both models with its coherence, for each direction of the answer. Needs the series
/// "input", "measured", "declared" and "final" with their residuals; what is missing is left out.
void specialist_figures(plot::Page& page, const IdentifyResult& result);

/// The series of an answer by its name; null: it has none.
const Series* series_named(const IdentifyResult& result, const std::string& name);

}  // namespace m100::lab::identify
