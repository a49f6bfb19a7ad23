// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::host_tests {

/// @returns the message of the Error that `act` throws; empty: it throws none.
template <typename Error, typename Act>
std::string refusal_by(const Act& act) {
  try {
    act();
  } catch (const Error& wrong) {
    return wrong.what();
  }
  return "";
}

}  // namespace m100::host_tests
