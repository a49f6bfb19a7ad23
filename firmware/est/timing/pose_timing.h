// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "firmware/est/measurement.h"
#include "firmware/est/timing/pose_clock.h"
#include "firmware/est/timing/pose_latency.h"

namespace m100::est {

/// Properties of the path of a pose from its capture to its arrival.
template <typename T>
struct PoseTimingReport {
  core::Duration min_latency{0};  ///< constant latency, which every pose has
  core::Duration jitter{0};       ///< in addition: 99th percentile
  core::Duration interval{0};     ///< between two captures; zero: not known yet
  core::Duration unreported{0};   ///< from capture to the arrival without jitter, as applied
  T sigma_s{0};                   ///< standard error of `unreported`
  bool observable = false;        ///< sigma_s is at most 10 ms; otherwise `unreported` is mostly the prior
  float drift = 0.F;              ///< of our clock against the sender's, as a ratio
  core::Duration set_by{0};       ///< how far the sender's clock was set or slewed since the beginning
  std::uint32_t times_set = 0;
  core::Duration unexplained{0};  ///< PoseClock::unexplained()
};

/// Determines when poses were captured, on our clock, from their times of arrival, their sender's time stamps and the
/// inertial measurements. PoseClock removes the jitter, PoseLatency finds the constant latency. A comparison of the
/// clocks gives the prior of that latency. The applied latency changes by at most 20 ms per second.
/// T is float or double.
template <typename T>
class PoseTiming {
 public:
  /// Before the observer, once per tick. Sets the time of capture of a new pose and its uncertainty.
  /// Measurement::disturbance_acceleration is added to the acceleration by the tilt, where it is known.
  /// @param heading as estimated in the tick before
  void update(Measurement<T>& measured, const core::SinCos<T>& heading);
  const PoseTimingReport<T>& report() const { return report_; }

 private:
  void add_attitude(const Measurement<T>& measured, const core::SinCos<T>& heading);
  void update_latency(core::Duration way);
  void update_jitter(float late_s);
  void compare_clocks(const core::ClockOffset& offset);
  void set_prior(const core::Pose<T>& pose, core::TimePoint regular);

  PoseClock clock_;
  PoseLatency<T> latency_;
  Quantile jitter_{0.99F, 1e-3F};
  float min_of_run_s_ = 0.F;  ///< smallest lateness in the run of poses far later than jitter_
  std::uint32_t run_ = 0;
  core::TimePoint run_since_{};
  PoseTimingReport<T> report_;
  T applied_s_{0};  ///< the latency that is applied (`unreported`)
  core::TimePoint last_{};
  float min_latency_s_ = 0.F;   ///< least delay of an arrival after that without jitter
  core::ClockOffset offset_{};  ///< the last comparison of the clocks
  bool offset_is_old_ = false;  ///< offset_ is from before the sender's clock was set
  std::uint32_t sequence_ = 0;  ///< of the last pose
  bool begun_ = false;
};

extern template class PoseTiming<float>;
extern template class PoseTiming<double>;

}  // namespace m100::est
