// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_residual.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::sysid {
namespace {

template <typename Real>
constexpr Real kLimit = Real(2.5);  ///< a block with a larger ratio is over the limit
template <typename Real>
constexpr Real kFarLimit = Real(5);  ///< a single block with a larger ratio shows a departure
/// The response has departed when gain or delay exceed these limits by more than three standard errors. Delay: that of
/// a healthy aircraft. A tired battery takes 12 % of a loop's frequency, a load of 0.4 kg another 6 %; 2 zeta / w is
/// then longer by 33 ms. (60 ms must be noticed.) Gain: midway between the error of an identified gain (10 %) and the
/// error that must be noticed (30 %).
template <typename Real>
constexpr Real kLateLimit_s = Real(0.036);
template <typename Real>
constexpr Real kGainLimit = Real(0.2);
template <typename Real>
constexpr Real kSigmas = Real(3);
template <typename Real>
constexpr Real kEnoughSwing = Real(3);  ///< in floors: with a smaller swing, the loop reacts to wander (ResponseFit)

}  // namespace

template <typename Real>
[[gnu::cold]] AxisResidual<Real>::AxisResidual(const model::StickAxis& axis, Real expected_rms, Real sample_period_s)
    : lead_zero_s_(static_cast<Real>(axis.lead_zero_s)),
      expected_rms_(expected_rms),
      sample_period_s_(sample_period_s),
      law_(axis, sample_period_s),
      dynamics_(axis, sample_period_s),
      delayed_(static_cast<Real>(axis.transport_delay_s), sample_period_s),
      fit_(sample_period_s) {
  M100_ASSERT(expected_rms > Real(0));
}

template <typename Real>
void AxisResidual<Real>::update(Real stick_counts, Real other_counts, Real measured) {
  if (!(measured - measured == Real(0)) || !(stick_counts - stick_counts == Real(0))) {
    interrupt();  // not finite
    return;
  }
  window_.add({.measured = measured,
               .command = law_.command(stick_counts, other_counts, static_cast<Real>(sample_) * sample_period_s_)});
  ++sample_;
  if (window_.has_middle()) {
    process(window_.middle());
  }
}

template <typename Real>
void AxisResidual<Real>::interrupt() {
  window_.clear();
  running_ = false;
}

// Processes the middle sample of the window: adds its command to the past commands, its error to the block.
template <typename Real>
void AxisResidual<Real>::process(const typename SampleWindow<Real>::Sample& sample) {
  delayed_.add(sample.command);
  if (!running_) {
    if (!window_.is_full()) {
      before_ = delayed_.value();
      return;
    }
    begin_block();
  }
  const Real predicted = dynamics_.value();
  const Real error = predicted - sample.measured;
  sum_ += error * error;
  if (in_block_ >= kSettle) {
    fit_.add(predicted, (predicted - predicted_) / sample_period_s_, error);
  }
  predicted_ = predicted;
  const Real now = delayed_.value();
  dynamics_.step(now + lead_zero_s_ / sample_period_s_ * (now - before_));
  before_ = now;
  if (++in_block_ == kBlock) {
    end_block();
  }
}

template <typename Real>
void AxisResidual<Real>::begin_block() {
  const typename SampleWindow<Real>::Start start = window_.start(sample_period_s_);
  dynamics_.start(start.value, start.slope_per_s);
  sum_ = Real(0);
  in_block_ = 0;
  fit_.begin();
  running_ = true;
}

template <typename Real>
void AxisResidual<Real>::end_block() {
  const auto beyond = [](Real value, Real sigma, Real limit) {
    return (value < Real(0) ? -value : value) - kSigmas<Real> * sigma > limit;
  };
  report_.response_departed = false;
  if (fit_.end()) {
    report_.response = fit_.report();
    report_.response_departed = report_.response.swing >= kEnoughSwing<Real> * expected_rms_ &&
                                (beyond(report_.response.gain, report_.response.gain_sigma, kGainLimit<Real>) ||
                                 beyond(report_.response.late_s, report_.response.late_sigma_s, kLateLimit_s<Real>));
  }
  const auto square = [](Real value) { return value * value; };
  const Real expected =
      square(expected_rms_) + square(kTiming_s) * fit_.block_slope() + square(kGain) * fit_.block_swing();
  report_.block_rms = core::sqrt(sum_ / static_cast<Real>(kBlock));
  report_.ratio = core::sqrt(fit_.block_error() / expected);
  ++report_.blocks;
  report_.blocks_over = report_.ratio > kLimit<Real> ? report_.blocks_over + 1 : 0;
  report_.departed = report_.response_departed || report_.blocks_over >= 2 || report_.ratio > kFarLimit<Real>;
  running_ = false;
}

template class AxisResidual<float>;
template class AxisResidual<double>;

}  // namespace m100::sysid
