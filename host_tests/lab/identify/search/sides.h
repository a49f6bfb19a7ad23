// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/search/study.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {

/// The request cut to the sides of a change on which a model can be chosen and tested, the longer one first. Where the
/// cut leaves no validation part, the last third is taken for it. Empty: neither side is long enough.
std::vector<Request> sides_of(const Request& request, const Change& change);

/// One side of a change, with the structure that was chosen on it alone.
template <typename StudyOf>
struct CalmSide {
  std::unique_ptr<Request> request;  ///< outlives the study
  std::unique_ptr<StudyOf> study;
  Selection chosen;
};

/// A change spoils the structure, and a missing structure looks like a change: so the structure is chosen again on one
/// side of the date. The longer side is tried first. A side on which the stick rests, or that gaps cut up, makes no
/// study and is passed over. Empty: neither side makes one.
/// @param more  what the study's constructor takes behind the request
template <typename StudyOf, typename... More>
std::optional<CalmSide<StudyOf>> calm_side(const Request& request, const Change& change,
                                           const SelectionOptions& options, const More&... more) {
  for (const Request& side : sides_of(request, change)) {
    CalmSide<StudyOf> calm{.request = std::make_unique<Request>(side), .study = nullptr, .chosen = {}};
    try {
      calm.study = std::make_unique<StudyOf>(*calm.request, more...);
    } catch (const InputError&) {
      continue;
    }
    calm.chosen = choose(*calm.study, *calm.request, options);
    return calm;
  }
  return std::nullopt;
}

/// Adds a change to the answer. Where other names fit as well, what changed is unexplained.
void add_change(Beside& beside, const Change& change);

/// Says that effects, errors and intervals are those of one side of a change.
Finding side_note(const Request& side);

}  // namespace m100::lab::identify
