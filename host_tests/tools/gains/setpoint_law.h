// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/mpc/gain_table.h"

namespace m100::tools::gains {

/// The rows of one axis' set-point law, owned.
struct SetpointRows {
  std::vector<double> planes;
  std::vector<double> laws;
  std::vector<mpc::SetpointNode> nodes;
};

}  // namespace m100::tools::gains
