// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/timing/pose_timing.h"

#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/model/vehicle.h"

namespace m100::est {
namespace {

// Prior of the latency. If the clocks were compared, it follows from the sender's time stamp, with a sigma of
// kReportedSigma_s or the bound of the comparison, whichever is larger. Otherwise it is kUnreported_s.
constexpr double kReportedSigma_s = 0.020;
constexpr double kUnreported_s = 0.030;
constexpr double kUnreportedSigma_s = 0.040;
constexpr double kOldest_s = 0.25;         // largest latency of PoseLatency
constexpr double kSlew = 0.02;             // largest change of the applied latency, s per s
constexpr double kLeftOfJitter_s = 0.002;  // jitter that PoseClock leaves
constexpr double kRawSigma_s = 0.015;      // jitter without PoseClock
constexpr float kMinRises = 1e-5F;         // rise of the least latency, s per pose
constexpr float kFarLater_s = 0.010F;      // beyond the jitter known so far: far later
constexpr std::uint32_t kChanged = 4;      // such poses in a row: chance hardly exceeds a 99th percentile so often
constexpr core::Duration kNoQueue =
    std::chrono::milliseconds(300);  // least duration of such a row: a queue has drained by then

}  // namespace

template <typename T>
void PoseTiming<T>::add_attitude(const Measurement<T>& measured, const core::SinCos<T>& heading) {
  const typename Measurement<T>::Attitude& attitude = measured.attitude;
  const core::Slope<T> slope = core::slope_of<T>({.roll = attitude.roll(), .pitch = attitude.pitch(), .yaw = heading});
  constexpr T kGravity = static_cast<T>(model::kGravity_m_s2);
  const core::Vector<T, 2> tilted_m_s2(kGravity * slope.x, -kGravity * slope.y);
  latency_.add_acceleration(measured.now - attitude.age,
                            measured.disturbance_acceleration.is_known
                                ? tilted_m_s2 + measured.disturbance_acceleration.now_w_m_s2
                                : tilted_m_s2);
}

/// If the transport has become slower for good, the jitter follows within the time of a COAST: it is raised to the
/// smallest lateness of a row of late poses. The row must last kNoQueue, because poses also queue up during a pause.
template <typename T>
void PoseTiming<T>::update_jitter(float late_s) {
  const bool is_far = late_s > jitter_.value_s() + kFarLater_s;
  min_of_run_s_ = run_ == 0 || late_s < min_of_run_s_ ? late_s : min_of_run_s_;
  run_since_ = run_ == 0 ? last_ : run_since_;
  run_ = is_far ? run_ + 1 : 0;
  jitter_.update(late_s);
  if (run_ >= kChanged && last_ - run_since_ >= kNoQueue) {
    jitter_.set(min_of_run_s_);
    run_ = 0;
  }
}

template <typename T>
void PoseTiming<T>::update_latency(core::Duration way) {
  const float way_s = core::seconds<float>(way);
  const float risen_s = min_latency_s_ + kMinRises;
  min_latency_s_ = way_s < risen_s ? way_s : risen_s;
  update_jitter(way_s - min_latency_s_);
  report_.min_latency = duration_of(min_latency_s_) + report_.unreported;
  report_.min_latency = report_.min_latency > core::Duration{0} ? report_.min_latency : core::Duration{0};
  report_.jitter = duration_of(jitter_.value_s());
  report_.interval = clock_.interval();
  report_.drift = clock_.drift();
}

/// If a comparison differs from the one before by more than the sum of their bounds, the sender's clock was set.
template <typename T>
void PoseTiming<T>::compare_clocks(const core::ClockOffset& offset) {
  const core::Duration lost = offset.to_ours - offset_.to_ours;
  const core::Duration bound = offset.bound + offset_.bound;
  const bool was_set = offset.known && offset_.known && (lost > bound || lost < -bound);
  if (was_set && lost > core::Duration{0}) {
    clock_.lose(lost);
  }
  offset_is_old_ = offset_is_old_ && !was_set && offset.known;
  offset_ = offset;
}

template <typename T>
void PoseTiming<T>::set_prior(const core::Pose<T>& pose, core::TimePoint regular) {
  if (!pose.offset.known) {
    latency_.set_prior(static_cast<T>(kUnreported_s), static_cast<T>(kUnreportedSigma_s));
    return;
  }
  const core::TimePoint reported(pose.captured.time_since_epoch() + pose.offset.to_ours);
  const T bound_s = core::seconds<T>(pose.offset.bound);
  constexpr T kMin_s = static_cast<T>(kReportedSigma_s);
  latency_.set_prior(core::clamp(core::seconds<T>(regular - reported), T(0), static_cast<T>(kOldest_s)),
                     bound_s > kMin_s ? bound_s : kMin_s);
}

template <typename T>
void PoseTiming<T>::update(Measurement<T>& measured, const core::SinCos<T>& heading) {
  if (measured.attitude.is_new) {
    add_attitude(measured, heading);
  }
  if (!measured.pose.is_new) {
    return;
  }
  core::Pose<T>& pose = measured.pose;
  compare_clocks(pose.offset);
  const std::uint32_t poses = pose.sequence - sequence_;
  sequence_ = pose.sequence;
  const core::TimePoint regular = clock_.update(
      pose.captured, pose.arrived, {.clock_was_set = pose.clock_was_set, .poses = begun_ && poses > 0 ? poses : 1U});
  offset_is_old_ = offset_is_old_ || clock_.times_set() != report_.times_set;
  report_.times_set = clock_.times_set();
  report_.set_by = clock_.set_by();
  report_.unexplained = clock_.unexplained();
  if (!offset_is_old_) {
    set_prior(pose, regular);
  }
  if (!begun_) {
    begun_ = true;
    applied_s_ = latency_.tau_s();
    last_ = measured.now;
  }
  latency_.add_pose(regular, {pose.position_w_m.x(), pose.position_w_m.y()});

  const T most_s = static_cast<T>(kSlew) * core::seconds<T>(measured.now - last_);
  last_ = measured.now;
  applied_s_ += core::clamp(latency_.tau_s() - applied_s_, -most_s, most_s);
  report_.unreported = duration_of(applied_s_);
  const core::TimePoint captured = regular - report_.unreported;
  pose.set_captured_at(captured < pose.arrived ? captured : pose.arrived);
  update_latency(pose.arrived - regular);

  const T left_s = static_cast<T>(clock_.is_regular() ? kLeftOfJitter_s : kRawSigma_s);
  const T behind_s = latency_.tau_s() - applied_s_;
  report_.sigma_s = latency_.sigma_s();
  report_.observable = latency_.is_observable();
  pose.time_sigma_s = core::sqrt(left_s * left_s + behind_s * behind_s + report_.sigma_s * report_.sigma_s);
}

template class PoseTiming<float>;
template class PoseTiming<double>;

}  // namespace m100::est
