// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// The request cut to the sides of a change on which a model can be chosen and tested, the longer one first. Where the
/// cut leaves no validation part, the last third is taken for it. Empty: neither side is long enough.
std::vector<Request> sides_of(const Request& request, const Change& change);

/// Says that effects, errors and intervals are those of one side of a change.
Finding side_note(const Request& side);

}  // namespace m100::lab::identify
