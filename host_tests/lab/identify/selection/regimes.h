// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/selection/problem.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {

/// The request limited to each side of a change's interval, longer side first, without a side that is too short. If
/// both parts are of one log, a side with too little training or no validation is divided again, 2 to 1.
std::vector<Request> regimes_of(const Request& request, const Change& change);

/// One side of a change, with the structure that was selected on it alone.
template <typename ProblemType>
struct Regime {
  std::unique_ptr<Request> request;  ///< the problem refers to it
  std::unique_ptr<ProblemType> problem;
  Selection chosen;
};

/// Selects the structure again on one side of a change, because a change distorts the structure, and a missing effect
/// looks like a change. The longer side is tried first. A side without a usable problem (the stick rests, too many
/// gaps) is skipped. Empty: neither side is usable.
/// @param more  arguments of the problem's constructor after the request
template <typename ProblemType, typename... More>
std::optional<Regime<ProblemType>> select_regime(const Request& request, const Change& change,
                                                 const SelectionOptions& options, const More&... more) {
  for (const Request& side : regimes_of(request, change)) {
    Regime<ProblemType> regime{.request = std::make_unique<Request>(side), .problem = nullptr, .chosen = {}};
    try {
      regime.problem = std::make_unique<ProblemType>(*regime.request, more...);
    } catch (const InputError&) {
      continue;
    }
    regime.chosen = select_effects(*regime.problem, *regime.request, options);
    return regime;
  }
  return std::nullopt;
}

/// Adds a change to the findings. If the change has rivals, a sentence is added to `unexplained`, too.
void add_change(SideFindings& side_findings, const Change& change);

/// A note that effects, errors and intervals are from one side of a change only.
Finding regime_note(const Request& side);

}  // namespace m100::lab::identify
