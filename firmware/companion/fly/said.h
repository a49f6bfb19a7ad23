// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::companion {

/// What the operator said, or a room in his place, since one asked before.
struct Said {
  bool word = false;  ///< Enter, whatever stands before it, or SIGUSR1 where there is no terminal
  bool land = false;  ///< the line "land"
};

}  // namespace m100::companion
