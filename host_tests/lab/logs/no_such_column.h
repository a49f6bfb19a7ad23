// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/input_error.h"

namespace m100::lab::logs {

/// A column that a log does not have. Whoever was told its name by a file says where.
class NoSuchColumn : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace m100::lab::logs
