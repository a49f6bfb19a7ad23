// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "host_tests/lab/identify/answer/result.h"

namespace m100::lab::identify {

/// The result with the keys of `m100-lab identify --json`; series for figures are left out.
nlohmann::ordered_json to_json(const IdentifyResult& result);

/// The page a terminal shows: declared, found, before, after, and what is left.
std::string to_text(const IdentifyResult& result);
/// The key "refitted" alone, of one channel: what was believed beside what was found.
nlohmann::ordered_json to_json(const std::vector<Refitted>& refitted);

}  // namespace m100::lab::identify
