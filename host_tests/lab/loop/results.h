// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/loop/close_loop.h"

namespace m100::lab::loop {

/// One sentence for each quantity that the new vehicle file predicts worse than the old one by more than 2 %, 1 s ahead
/// on the third flight.
std::vector<std::string> predicted_worse(const LoopResult& result);
/// Sentences: the paired flights as flown, the rule, both laws' margins on the corrected model, and then the flights at
/// equal margin.
std::vector<std::string> verdicts(const LoopResult& result);
/// Shown where LoopResult::is_kept is false.
inline constexpr const char* kNotKept =
    "NOT KEPT: a task is worse as flown. --out holds the former vehicle file, and its tables stay; --keep-worse takes "
    "the new one";
void print(std::ostream& out, const LoopResult& result);
Json to_json(const LoopResult& result);

}  // namespace m100::lab::loop
