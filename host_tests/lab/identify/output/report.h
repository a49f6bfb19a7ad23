// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::identify {

/// Origin of the numbers, for the summary of the report.
struct ReportOrigin {
  std::string log;         ///< file name of the log
  std::string train;       ///< e.g. "12:38 s"
  std::string validation;  ///< e.g. "38:55.5 s"; equal to `train`: parts of it in turn
};

/// The text of the first finding that is certain and makes the parameters unfit to fly (kMisreadings); empty: none.
std::string misreading(const IdentifyResult& result);

/// The page of one axis: a misreading, then the answer with a figure of both models, the errors before and after, their
/// meaning for the flight, and the effects; then the figures (residual, autocorrelation, spectra, candidates,
/// intervals, horizons).
plot::Page report_page(const IdentifyResult& result, const ReportOrigin& origin);

/// Writes <axis>.html, and its series as <axis>.csv, into `directory`. @returns the page's path. Errors: InputError.
std::string write_report(const IdentifyResult& result, const ReportOrigin& origin, const std::string& directory);

}  // namespace m100::lab::identify
