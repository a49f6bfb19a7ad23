// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::ctl {

/// What the control law asks of the autopilot: body frame FLU, SI. +roll right side down, +pitch nose down (forward),
/// +climb up, +yaw rate counter-clockwise. The trim is not in it: vrc adds it.
template <typename T>
struct Command {
  T roll_rad{0};
  T pitch_rad{0};
  T climb_m_s{0};
  T yaw_rate_rad_s{0};
};

}  // namespace m100::ctl
