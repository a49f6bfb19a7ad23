// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "host_tests/lab/input_error.h"
#include "host_tests/own_folder.h"
#include "host_tests/refusal.h"
#include "host_tests/unit/logs/memory_log.h"

namespace m100::lab::logs {

/// @returns the error message of `act`; the test fails if there is none.
template <typename Act>
std::string complaint_of(const Act& act) {
  const std::string said = host_tests::refusal_by<InputError>(act);
  EXPECT_NE(said, "") << "accepted";
  return said;
}

}  // namespace m100::lab::logs
