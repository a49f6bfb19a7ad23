// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/core/time.h"

namespace m100::companion {

/// Takes lines for the operator and the log.
class Listener {
 public:
  virtual void hear(core::TimePoint now, std::string_view line) = 0;

 protected:
  Listener() = default;
  ~Listener() = default;
};

}  // namespace m100::companion
