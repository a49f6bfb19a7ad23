// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "firmware/companion/files/text/file_error.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"

namespace m100::sim {

/// One key of the file: a number with its range, or true and false.
struct RealAutopilotKey {
  std::string_view section, key;
  double& (*number)(N1Behaviour&) = nullptr;
  bool& (*flag)(N1Behaviour&) = nullptr;
  double low = 0.0, high = 0.0;
  std::span<const double> allowed{};  ///< empty: the whole range
};
std::span<const RealAutopilotKey> real_autopilot_keys();

/// Reads what was seen on a real autopilot (TOML); a key that is missing keeps the assumption.
/// @param name of the file, for errors. @throws companion::FileError: no TOML, an unknown key, a number out of range.
N1Behaviour parse_real_autopilot(std::string_view text, const std::string& name);

}  // namespace m100::sim
