// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {

/// The data of a figure for the browser: one line of JSON for the inside of a script element. The curves are sorted by
/// x, broken at gaps, and thinned to their extremes above 8000 points, unless the figure is a path (equal_axes).
std::string live_data(const Figure& figure);

/// What a page whose figures can be zoomed needs in its head: the library dygraphs (Debian's libjs-dygraphs, MIT) and
/// the script that draws with it. Empty if the library is not installed: the static drawings stay. Looks in the folder
/// that the environment variable M100_DYGRAPHS names, otherwise in Debian's.
std::string live_head();

}  // namespace m100::lab::plot
