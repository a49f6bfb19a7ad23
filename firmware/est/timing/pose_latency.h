// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"

namespace m100::est {

/// Estimates from the inertial measurements how much older the poses are than assumed. It uses scalar least squares in
/// windows of 1 s.
///
/// In a window, for each horizontal axis, with s the assumed time of capture and I the double integral of the
/// horizontal acceleration:
///   pose(s) = c0 + c1 s + c2 s^2 + I(s - tau) = c0 + c1 s + c2 s^2 + I(s) - tau I'(s) + ...
/// The polynomial absorbs the initial values of the integrals and all steady accelerations: wind, trim, offsets. It is
/// eliminated from the normal equations at the end of the window, which leaves tau and its information. Windows are
/// summed with a memory of a minute.
///
/// In a still hover I' carries no information, and tau keeps its prior.
/// T is float or double. Cost: 2 integrals a tick, about 45 products a pose.
template <typename T>
class PoseLatency {
 public:
  using Vector2 = core::Vector<T, 2>;
  static constexpr double kKnown_s = 0.010;  ///< largest standard error of an observable latency

  /// Sets the prior by mean and standard deviation. If the motion contradicts it, the deviation of the prior becomes
  /// its distance from the estimate by motion.
  void set_prior(T tau_s, T sigma_s);
  /// The horizontal acceleration (world, m/s^2) at a time; times must ascend.
  void add_acceleration(core::TimePoint at, const Vector2& acceleration_w_m_s2);
  /// A pose (world, m), with its time of capture before the correction by tau.
  void add_pose(core::TimePoint captured, const Vector2& position_w_m);
  /// Discards the window that has begun, and the integrals: they no longer belong to the same motion.
  void interrupt();

  T tau_s() const { return tau_s_; }
  T sigma_s() const { return sigma_s_; }
  bool is_observable() const { return sigma_s_ <= static_cast<T>(kKnown_s); }

 private:
  struct Entry {
    core::TimePoint at{};
    Vector2 velocity = Vector2::Zero();
    Vector2 position = Vector2::Zero();
  };
  static constexpr std::size_t kEntries = 32;
  /// Sums of the normal equations; the matrix of the polynomial consists of the power sums of s.
  struct Sums {
    std::array<T, 5> power{};
    std::array<std::array<T, 3>, 2> by_rate{};       ///< s^k I', per axis
    std::array<std::array<T, 3>, 2> by_remainder{};  ///< s^k z, z = pose - I
    std::array<T, 2> rate_rate{}, rate_remainder{}, remainder_remainder{};
    std::uint32_t count = 0;
  };

  const Entry& ago(std::size_t steps) const { return entries_[(newest_ + kEntries - steps) % kEntries]; }
  bool interpolate(core::TimePoint at, Entry& seen) const;
  void rebase();
  void close_window();
  void update_estimate();

  std::array<Entry, kEntries> entries_{};
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
  Vector2 acceleration_ = Vector2::Zero();
  Sums sums_;
  core::TimePoint window_begin_{};
  Vector2 window_origin_ = Vector2::Zero();
  T prior_s_{0}, prior_information_{0};
  T information_{0}, weighted_{0};  ///< summed over all windows
  T tau_s_{0}, sigma_s_{0};
  T tau_in_window_s_{0};
};

extern template class PoseLatency<float>;
extern template class PoseLatency<double>;

}  // namespace m100::est
