// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/model/vehicle.h"
#include "firmware/sysid/axis_residual.h"

namespace m100::sysid {

/// The monitored stick axes, in the order of the arrays of ResidualMonitor::Sample.
enum class MonitoredAxis : std::uint8_t { kRoll, kPitch, kYawRate, kClimb };
inline constexpr std::size_t kMonitoredAxes = 4;

/// Computes the residuals of all monitored stick axes, each by an AxisResidual.
template <typename Real>
class ResidualMonitor {
 public:
  /// Expected residual of each channel, in its unit; the defaults are twice the floor of the measured flights.
  struct Expected {
    Real roll_rad = Real(0.008);
    Real pitch_rad = Real(0.006);
    Real yaw_rate_rad_s = Real(0.05);
    Real climb_m_s = Real(0.07);
  };
  /// @param line_s  time from the tick that sends a stick until the autopilot has it, plus from the measurement of the
  ///        attitude to the tick that reads it: the vehicle file's delay (from stick to attitude) does not include them
  ResidualMonitor(const model::Vehicle& vehicle, const Expected& expected, Real sample_period_s, Real line_s);

  /// Sticks as sent, in counts from 1024, less the trims' difference from the vehicle file's where it is known.
  struct Sample {
    std::array<Real, kMonitoredAxes> stick_counts{};
    std::array<Real, kMonitoredAxes> measured{};  ///< unit of the axis
  };
  void update(const Sample& sample);
  void interrupt();
  const ResidualReport<Real>& report(MonitoredAxis channel) const {
    return channels_[static_cast<std::size_t>(channel)].report();
  }
  /// The channel whose last block has the largest ratio to its expected residual.
  MonitoredAxis worst() const;
  /// Whether any channel has departed from its model.
  bool departed() const;

 private:
  std::array<AxisResidual<Real>, kMonitoredAxes> channels_;
};

}  // namespace m100::sysid
