// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/plot/html.h"

namespace m100::lab::report {

/// The question of a page, and the files that the subcommands wrote with --json (empty: there is none).
struct Sources {
  std::string asked;                    ///< the question that the page answers
  std::vector<std::string> identified;  ///< of identify, one for each axis
  std::string origin;                   ///< of the identified logs: "measured", "simulated", or empty: not known
  std::string experiments;
  std::string loop;
  std::string margins;  ///< of gains
  bool any() const { return !identified.empty() || !experiments.empty() || !loop.empty() || !margins.empty(); }
};

/// Writes the first screen of a page: what was asked, what the model lacks, how much error that explains, what it
/// changed in flight, what remains, with a figure beside it; then the errors before and after. Each number is marked as
/// measured or simulated where that is known. Errors: InputError.
void summarise(const Sources& sources, plot::Page& page);

}  // namespace m100::lab::report
