// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// The result with the keys of `m100-lab identify --json`; series for figures are left out.
Json to_json(const IdentifyResult& result);

/// The result as text for a terminal: both models and their errors, effects, intervals, changes, findings, verdict.
std::string to_text(const IdentifyResult& result);
/// The value of the key "refitted": believed and found parameters of one channel.
Json to_json(const std::vector<Refitted>& refitted);

}  // namespace m100::lab::identify
