// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "firmware/est/measurement.h"
#include "firmware/est/pose_clock.h"
#include "firmware/est/pose_latency.h"

namespace m100::est {

/// What was found about the way of a pose, from its capture until it is here.
template <typename T>
struct PoseTimingReport {
  core::Duration least{0};     ///< the latency that every pose has
  core::Duration jitter{0};    ///< on top of it: 99th percentile
  core::Duration interval{0};  ///< between two captures; zero: not known yet
  core::Duration untold{0};    ///< how much older than told the poses are
  T sigma_s{0};                ///< of that
  bool observable = false;     ///< motion has told it to 10 ms; else it is what was believed before
  float drift = 0.F;           ///< of our clock against the sender's, as a share
};

/// Says when poses were captured, on our clock, from when they came, their sender's stamps, and what the inertial
/// sensors saw: jitter by PoseClock, the constant rest by PoseLatency. Where both sides have compared their clocks,
/// that is what is believed of the rest beforehand, as far as unequal ways there and back allow; motion decides. What
/// is found is taken over at 20 ms a second, so that a pose in motion never jumps. T is float or double.
template <typename T>
class PoseTiming {
 public:
  /// Before the observer, once per tick. Sets the capture of a new pose and the uncertainty of its time.
  /// What the force shows beside the tilt (Measurement::push) counts as acceleration, where it is known: without it a
  /// tilt that only answers a gust or drag looks like a motion that came 10 to 30 ms earlier or later.
  /// @param yaw_rad as estimated in the tick before
  void update(Measurement<T>& measured, T yaw_rad);
  const PoseTimingReport<T>& report() const { return report_; }

 private:
  void note_attitude(const Measurement<T>& measured, T yaw_rad);
  void note_way(core::Duration way);
  void note_jitter(float late_s);
  void believe(const core::Pose<T>& pose, core::TimePoint regular);

  PoseClock clock_;
  PoseLatency<T> latency_;
  Quantile jitter_{0.99F, 1e-3F};
  float least_of_run_s_ = 0.F;  ///< of those in a row that came far later than jitter_
  std::uint32_t run_ = 0;
  core::TimePoint run_since_{};
  PoseTimingReport<T> report_;
  T applied_s_{0};  ///< of the latency beyond what is told
  core::TimePoint last_{};
  float least_s_ = 0.F;  ///< from the capture without jitter to the arrival
  bool begun_ = false;
};

extern template class PoseTiming<float>;
extern template class PoseTiming<double>;

}  // namespace m100::est
