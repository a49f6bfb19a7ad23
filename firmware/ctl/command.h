// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::ctl {

/// Command of the control law to the autopilot: body frame FLU, SI. +roll right side down, +pitch nose down (forward),
/// +climb up, +yaw rate counter-clockwise. It does not include the trim, which vrc adds.
template <typename T>
struct Command {
  T roll_rad{0};
  T pitch_rad{0};
  T climb_m_s{0};
  T yaw_rate_rad_s{0};
};

}  // namespace m100::ctl
