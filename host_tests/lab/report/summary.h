// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/plot/html.h"

namespace m100::lab::report {

/// Results as the subcommands write them with --json; empty: there is none.
struct Sources {
  std::vector<std::string> identified;  ///< of identify, one for each axis
  bool measured = false;                ///< whether the identified logs were flown by an aircraft
  std::string experiments;
  std::string loop;
  std::string margins;  ///< of gains
  bool any() const { return !identified.empty() || !experiments.empty() || !loop.empty() || !margins.empty(); }
};

/// The first screen of a page: what was found, prediction and flight before and after, what was not reached; each
/// number with whether it is measured or simulated. Errors: InputError.
void summarise(const Sources& sources, plot::Page& page);

}  // namespace m100::lab::report
