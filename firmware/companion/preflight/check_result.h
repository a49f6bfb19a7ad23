// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::companion::preflight {

enum class Health { kGood, kDoubtful, kBad };

struct CheckResult {
  std::string name;
  Health health = Health::kGood;
  std::string finding;
  std::string remedy;  ///< empty: nothing needs to be done
};

}  // namespace m100::companion::preflight
