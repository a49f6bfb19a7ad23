// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/core/time.h"

namespace m100::companion {

/// Takes lines for the operator; OperatorChannels also logs them.
class OperatorLog {
 public:
  virtual void write(core::TimePoint now, std::string_view line) = 0;

 protected:
  OperatorLog() = default;
  ~OperatorLog() = default;
};

}  // namespace m100::companion
