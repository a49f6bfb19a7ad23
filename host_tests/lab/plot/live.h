// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {

/// The data of a figure for the browser: one line of JSON that may stand inside a script element. Curves are in the
/// order of x and broken at gaps; curves of more than 8000 points are thinned to their extremes.
std::string live_data(const Figure& figure);

/// What a page with such figures needs in its head: the library dygraphs (Debian's libjs-dygraphs, MIT) and the script
/// that draws with it. Empty where the library is not installed: then the static drawings stay.
/// Looks in the folder that the environment's M100_DYGRAPHS names, otherwise in Debian's.
std::string live_head();

}  // namespace m100::lab::plot
