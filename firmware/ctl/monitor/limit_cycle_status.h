// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::ctl {

/// The oscillation of the control loop that LimitCycleDetector finds.
struct LimitCycleStatus {
  double height_rad = 0.0;    ///< of the tilt, peak to peak, when last detected
  double frequency_hz = 0.0;  ///< when last detected
  bool detected = false;      ///< it was detected since the law began to fly, and the fallback law flies since then
  bool persists = false;      ///< it continues under the fallback law
};

}  // namespace m100::ctl
