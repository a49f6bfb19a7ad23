// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>

#include "firmware/model/stick_axis.h"
#include "firmware/model/vehicle.h"
#include "firmware/sysid/axis_dynamics.h"

namespace m100::lab::excite {

/// The axis with defaults for missing parameters, and with the stick counted from its trim.
inline model::StickAxis flyable(model::StickAxis axis) {
  if (!axis.is_identified()) {
    axis.natural_frequency_rad_s = 8.7;
    axis.damping_ratio = 0.7;
  }
  axis.trim_counts = 0.0;
  return axis;
}

/// Simulates the response of an axis to its stick, and the motion of the vehicle along (or about) the axis.
class StickFlight {
 public:
  StickFlight(const model::StickAxis& axis, bool rate)
      : rate_(rate),
        lead_steps_(axis.lead_zero_s / kStep_s),
        law_(axis, kStep_s),
        dynamics_(axis, kStep_s),
        line_(static_cast<std::size_t>(std::lround(axis.transport_delay_s / kStep_s)) + 1, 0.0) {}

  void step(double stick_counts, double other_counts, double period_s) {
    for (double t = 0.0; t < period_s - 1e-9; t += kStep_s) {
      line_.push_back(law_.command(stick_counts, other_counts, now_s_));
      const double before = line_[0];
      line_.pop_front();
      dynamics_.step(line_[0] + lead_steps_ * (line_[0] - before));
      const double tilt_rad = std::clamp(angle(), -1.0, 1.0);
      speed_m_s_ = rate_ ? angle() : speed_m_s_ + kStep_s * model::kGravity_m_s2 * std::tan(tilt_rad);
      position_m_ += kStep_s * speed_m_s_;
      now_s_ += kStep_s;
    }
  }
  double angle() const { return dynamics_.value(); }
  double position_m() const { return position_m_; }
  double speed_m_s() const { return speed_m_s_; }

 private:
  static constexpr double kStep_s = 0.002;
  bool rate_;
  double lead_steps_;
  model::StickLaw<double> law_;
  sysid::AxisDynamics<double> dynamics_;
  std::deque<double> line_;  ///< delay line of commands, oldest first
  double position_m_ = 0.0, speed_m_s_ = 0.0, now_s_ = 0.0;
};

}  // namespace m100::lab::excite
