// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/consistency_check.h"

#include <array>

namespace m100::est {
namespace {

struct Row {
  std::string_view name;
  std::string_view unit;
};

constexpr std::array<Row, kCheckCount> kRows{{{"none", ""},
                                              {"force", "m/s"},
                                              {"climb", "m/s"},
                                              {"heading", "rad"},
                                              {"motion", "m"},
                                              {"rates", "rad"},
                                              {"answer", "rad"},
                                              {"height", "m"}}};

constexpr const Row& row(ConsistencyCheck check) { return kRows[static_cast<std::size_t>(check)]; }

}  // namespace

std::string_view name(ConsistencyCheck check) { return row(check).name; }
std::string_view unit_of(ConsistencyCheck check) { return row(check).unit; }

std::optional<ConsistencyCheck> check_of(std::string_view name) {
  for (std::size_t i = 1; i < kCheckCount; ++i) {
    if (kRows[i].name == name) {
      return static_cast<ConsistencyCheck>(i);
    }
  }
  return std::nullopt;
}

}  // namespace m100::est
