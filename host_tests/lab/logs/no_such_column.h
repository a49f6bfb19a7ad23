// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/input_error.h"

namespace m100::lab::logs {

/// Thrown for a name of which the log has no column. A caller that read the name from a file throws an InputError with
/// that file and line instead.
class NoSuchColumn : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace m100::lab::logs
