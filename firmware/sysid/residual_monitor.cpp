// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/residual_monitor.h"

namespace m100::sysid {
namespace {

template <typename Real>
model::StickAxis behind(model::StickAxis axis, Real line_s) {
  axis.transport_delay_s += static_cast<double>(line_s);
  return axis;
}

}  // namespace

template <typename Real>
[[gnu::cold]] ResidualMonitor<Real>::ResidualMonitor(const model::Vehicle& vehicle, const Expected& expected,
                                                     Real sample_period_s, Real line_s)
    : channels_{AxisResidual<Real>(behind(vehicle.roll, line_s), expected.roll_rad, sample_period_s),
                AxisResidual<Real>(behind(vehicle.pitch, line_s), expected.pitch_rad, sample_period_s),
                AxisResidual<Real>(behind(vehicle.yaw_rate, line_s), expected.yaw_rate_rad_s, sample_period_s),
                AxisResidual<Real>(behind(vehicle.climb, line_s), expected.climb_m_s, sample_period_s)} {}

template <typename Real>
void ResidualMonitor<Real>::update(const Sample& sample) {
  constexpr std::array<std::size_t, kMonitoredAxes> kOther{1, 0, 2, 3};  // roll and pitch couple into each other
  for (std::size_t channel = 0; channel < kMonitoredAxes; ++channel) {
    channels_[channel].update(sample.stick_counts[channel], sample.stick_counts[kOther[channel]],
                              sample.measured[channel]);
  }
}

template <typename Real>
void ResidualMonitor<Real>::interrupt() {
  for (AxisResidual<Real>& channel : channels_) {
    channel.interrupt();
  }
}

template <typename Real>
MonitoredAxis ResidualMonitor<Real>::worst() const {
  std::size_t worst = 0;
  for (std::size_t channel = 1; channel < kMonitoredAxes; ++channel) {
    if (channels_[channel].report().ratio > channels_[worst].report().ratio) {
      worst = channel;
    }
  }
  return static_cast<MonitoredAxis>(worst);
}

template <typename Real>
bool ResidualMonitor<Real>::departed() const {
  for (const AxisResidual<Real>& channel : channels_) {
    if (channel.report().departed) {
      return true;
    }
  }
  return false;
}

template class ResidualMonitor<float>;
template class ResidualMonitor<double>;

}  // namespace m100::sysid
