// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace m100::sysid {

/// Whether the aircraft is still the one of the vehicle file.
struct ModelStatus {
  std::array<bool, 4> mismatch{};  ///< roll, pitch, yaw rate, climb: the axis no longer follows its model
  bool trim_drifted = false;       ///< a trim differs from the vehicle file
};

}  // namespace m100::sysid
