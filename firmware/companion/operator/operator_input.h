// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::companion {

/// The commands of the operator, or of a ground station in the operator's place, since the last call.
struct OperatorInput {
  bool toggle_control = false;  ///< any line but "land", or SIGUSR1: takes control or gives it back
  bool land = false;            ///< the line "land"
};

}  // namespace m100::companion
