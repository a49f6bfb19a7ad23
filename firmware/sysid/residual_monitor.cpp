// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/residual_monitor.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::sysid {
namespace {

template <typename Real>
model::StickAxis behind(model::StickAxis axis, Real line_s) {
  axis.transport_delay_s += static_cast<double>(line_s);
  return axis;
}

}  // namespace

template <typename Real>
[[gnu::cold]] AxisResidual<Real>::AxisResidual(const model::StickAxis& axis, Real expected_rms, Real sample_period_s)
    : delay_s_(static_cast<Real>(axis.transport_delay_s)),
      lead_zero_s_(static_cast<Real>(axis.lead_zero_s)),
      expected_rms_(expected_rms),
      sample_period_s_(sample_period_s),
      law_(axis, sample_period_s),
      dynamics_(axis, sample_period_s),
      fit_(sample_period_s) {
  M100_ASSERT(expected_rms > Real(0));
  M100_ASSERT(delay_s_ <= sample_period_s * static_cast<Real>(kDelay - 2));
}

template <typename Real>
void AxisResidual<Real>::update(Real stick_counts, Real other_counts, Real measured) {
  if (!(measured - measured == Real(0)) || !(stick_counts - stick_counts == Real(0))) {
    interrupt();  // not finite
    return;
  }
  newest_ = (newest_ + 1) % measured_.size();
  measured_[newest_] = measured;
  commands_[newest_] = law_.command(stick_counts, other_counts, static_cast<Real>(sample_) * sample_period_s_);
  ++sample_;
  if (filled_ < measured_.size()) {
    ++filled_;
  }
  if (filled_ > kHalfWindow) {
    process((newest_ + measured_.size() - kHalfWindow) % measured_.size());
  }
}

template <typename Real>
void AxisResidual<Real>::interrupt() {
  filled_ = 0;
  running_ = false;
}

// Processes the middle sample of the window: adds its command to the past commands, its error to the block.
template <typename Real>
void AxisResidual<Real>::process(std::size_t slot) {
  past_newest_ = (past_newest_ + 1) % kDelay;
  past_commands_[past_newest_] = commands_[slot];
  if (!running_) {
    if (filled_ < measured_.size()) {
      before_ = delayed_command();
      return;
    }
    begin_block();
  }
  const Real predicted = dynamics_.value();
  const Real error = predicted - measured_[slot];
  sum_ += error * error;
  if (in_block_ >= kSettle) {
    fit_.add(predicted, (predicted - predicted_) / sample_period_s_, error);
  }
  predicted_ = predicted;
  const Real now = delayed_command();
  dynamics_.step(now + lead_zero_s_ / sample_period_s_ * (now - before_));
  before_ = now;
  if (++in_block_ == kBlock) {
    end_block();
  }
}

// Sums over x = -5 .. 5: of 1, 11; of x^2, 110; of x^4, 1958. Value and slope of the least-squares quadratic at x = 0.
template <typename Real>
void AxisResidual<Real>::begin_block() {
  Real m0 = Real(0);
  Real m1 = Real(0);
  Real m2 = Real(0);
  const std::size_t oldest = (newest_ + 1) % measured_.size();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const Real y = measured_[(oldest + i) % measured_.size()];
    const Real x = static_cast<Real>(i) - static_cast<Real>(kHalfWindow);
    m0 += y;
    m1 += x * y;
    m2 += x * x * y;
  }
  const Real value = (Real(1958) * m0 - Real(110) * m2) / Real(9438);
  dynamics_.start(value, m1 / (Real(110) * sample_period_s_));
  sum_ = Real(0);
  in_block_ = 0;
  fit_.begin();
  running_ = true;
}

template <typename Real>
void AxisResidual<Real>::end_block() {
  const auto beyond = [](Real value, Real sigma, Real limit) {
    return (value < Real(0) ? -value : value) - kSigmas * sigma > limit;
  };
  report_.response_departed = false;
  if (fit_.end()) {
    report_.response = fit_.report();
    report_.response_departed = report_.response.swing >= kEnoughSwing * expected_rms_ &&
                                (beyond(report_.response.gain, report_.response.gain_sigma, kGainLimit) ||
                                 beyond(report_.response.late_s, report_.response.late_sigma_s, kLateLimit_s));
  }
  const auto square = [](Real value) { return value * value; };
  const Real expected =
      square(expected_rms_) + square(kTiming_s) * fit_.block_slope() + square(kGain) * fit_.block_swing();
  report_.block_rms = core::sqrt(sum_ / static_cast<Real>(kBlock));
  report_.ratio = core::sqrt(fit_.block_error() / expected);
  ++report_.blocks;
  report_.blocks_over = report_.ratio > kLimit ? report_.blocks_over + 1 : 0;
  report_.departed = report_.response_departed || report_.blocks_over >= 2 || report_.ratio > kFarLimit;
  running_ = false;
}

template <typename Real>
Real AxisResidual<Real>::delayed_command() const {
  const Real samples = delay_s_ / sample_period_s_;
  const auto whole = static_cast<std::size_t>(samples);
  const Real part = samples - static_cast<Real>(whole);
  const Real newer = past_commands_[(past_newest_ + kDelay - whole) % kDelay];
  const Real older = past_commands_[(past_newest_ + kDelay - whole - 1) % kDelay];
  return newer + part * (older - newer);
}

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

template class AxisResidual<float>;
template class AxisResidual<double>;
template class ResidualMonitor<float>;
template class ResidualMonitor<double>;

}  // namespace m100::sysid
