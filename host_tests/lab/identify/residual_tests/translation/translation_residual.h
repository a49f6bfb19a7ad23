// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/translation_data_set.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify::translation {

/// Tests whether the residual of a fit on both parts, axis by axis, is still predictable.
/// Preconditions: both parts are of the request, have one thrust source and at least one block each.
/// @returns sentences; empty: the residual is not predictable.
std::vector<std::string> residual_findings(const Request& request, const TranslationDataSet& training,
                                           const TranslationDataSet& validation, const Fit& fit);

}  // namespace m100::lab::identify::translation
