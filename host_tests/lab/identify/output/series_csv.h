// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// Writes the series of the figures as CSV: `t_s`, `validation` (1 in the validation part), and a column for each: the
/// input in its own unit; measured, both models and residuals in the axis' unit. @throws InputError: cannot be written.
void write_series(const IdentifyResult& result, const std::string& file);

}  // namespace m100::lab::identify
