// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::ctl {

/// The aircraft's own oscillation.
struct LimitCycleStatus {
  double height_rad = 0.0;    ///< of the tilt, trough to crest, when last noticed
  double frequency_hz = 0.0;  ///< at that time
  bool detected = false;      ///< it was noticed in this flight, and the fallback law flies since then
  bool persists = false;      ///< it continues under the fallback law
};

}  // namespace m100::ctl
