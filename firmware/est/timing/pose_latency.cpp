// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/timing/pose_latency.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

constexpr core::Duration kWindow = std::chrono::seconds(1);
constexpr core::Duration kGap = std::chrono::milliseconds(50);  // without an attitude: the integral is no longer valid
constexpr double kHalfWindow_s = 0.5;
constexpr double kMemoryPerWindow = 0.98347145382161749;  // exp(-1/60)
constexpr std::uint32_t kFewest = 12;                     // poses in a useful window
constexpr double kMinResidual_m = 5e-4;                   // no pose is better than this
/// Errors of the model are correlated over a quarter of a second (gusts, the attitude loop), and over some ten poses:
/// so many poses count as one sample.
constexpr std::uint32_t kSamplesPerWindow = 4, kPosesPerSample = 10;
/// Range of the latency without the jitter: no pose comes before its capture.
constexpr double kEarliest_s = 0.0, kLatest_s = 0.25;
/// Smallest latency that a window assumes. The newest attitude is older than the newest pose, so a window needs to look
/// back this far to find its integrals.
constexpr double kLookback_s = 0.020;

template <typename T>
core::Duration cut_to_microseconds(T seconds) {
  return core::Duration(static_cast<core::Duration::rep>(seconds * T(1e6)));
}

/// Cholesky factor L of the symmetric 3 x 3 matrix of the power sums, and its forward substitution. The polynomial
/// is eliminated from a sum of products by subtracting the inner product of L^-1 a and L^-1 b (solve()).
template <typename T>
class Elimination {
 public:
  explicit Elimination(const std::array<T, 5>& power) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        T sum = power[i + j];
        for (std::size_t k = 0; k < j; ++k) {
          sum -= l_[i][k] * l_[j][k];
        }
        if (i == j) {
          positive_ = positive_ && sum > static_cast<T>(1e-4);
          l_[i][i] = core::sqrt(sum > static_cast<T>(1e-4) ? sum : static_cast<T>(1e-4));
        } else {
          l_[i][j] = sum / l_[j][j];
        }
      }
    }
  }
  bool positive() const { return positive_; }
  std::array<T, 3> solve(const std::array<T, 3>& right) const {
    std::array<T, 3> y{};
    for (std::size_t i = 0; i < 3; ++i) {
      T sum = right[i];
      for (std::size_t k = 0; k < i; ++k) {
        sum -= l_[i][k] * y[k];
      }
      y[i] = sum / l_[i][i];
    }
    return y;
  }

 private:
  std::array<std::array<T, 3>, 3> l_{};
  bool positive_ = true;
};

template <typename T>
T dot(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

template <typename T>
void PoseLatency<T>::set_prior(T tau_s, T sigma_s) {
  prior_s_ = tau_s;
  prior_information_ = T(1) / (sigma_s * sigma_s);
  update_estimate();
}

template <typename T>
void PoseLatency<T>::update_estimate() {
  T belief = prior_information_;
  if (information_ > T(0)) {
    // The prior's error, if motion is right: the prior's variance is at least its square, less the variance by motion.
    const T apart_s = weighted_ / information_ - prior_s_;
    const T apart_s2 = apart_s * apart_s - T(1) / information_;
    belief = apart_s2 * belief > T(1) ? T(1) / apart_s2 : belief;
  }
  const T all = information_ + belief;
  tau_s_ = core::clamp((weighted_ + belief * prior_s_) / all, static_cast<T>(kEarliest_s), static_cast<T>(kLatest_s));
  sigma_s_ = T(1) / core::sqrt(all);
}

template <typename T>
void PoseLatency<T>::interrupt() {
  sums_ = {};
  filled_ = 0;
}

template <typename T>
void PoseLatency<T>::add_acceleration(core::TimePoint at, const Vector2& acceleration_w_m_s2) {
  Entry next{.at = at};
  if (filled_ > 0) {
    const Entry& last = ago(0);
    if (at <= last.at) {
      return;
    }
    if (at - last.at > kGap) {
      interrupt();
    } else {
      const T step_s = core::seconds<T>(at - last.at);
      const Vector2 sum = acceleration_ + acceleration_w_m_s2;
      next.velocity = last.velocity + sum * (T(0.5) * step_s);
      next.position = last.position + last.velocity * step_s +
                      (sum + acceleration_) * (step_s * step_s * static_cast<T>(1.0 / 6.0));
    }
  }
  acceleration_ = acceleration_w_m_s2;
  newest_ = (newest_ + 1) % kEntries;
  entries_[newest_] = next;
  filled_ += filled_ < kEntries ? 1U : 0U;
}

/// Interpolates the integrals at a time into `seen`.
/// @returns false: the time is before the memory or after the newest attitude
template <typename T>
bool PoseLatency<T>::interpolate(core::TimePoint at, Entry& seen) const {
  for (std::size_t steps = 1; steps < filled_; ++steps) {
    const Entry& before = ago(steps);
    if (before.at > at) {
      continue;
    }
    const Entry& after = ago(steps - 1);
    const T since_s = core::seconds<T>(at - before.at);
    const T step_s = core::seconds<T>(after.at - before.at);
    const Vector2 acceleration = (after.velocity - before.velocity) / step_s;
    seen.velocity = before.velocity + acceleration * since_s;
    seen.position = before.position + before.velocity * since_s + acceleration * (T(0.5) * since_s * since_s);
    return at <= after.at;
  }
  return false;
}

/// Restarts the integrals at the oldest entry, so that they stay small.
template <typename T>
void PoseLatency<T>::rebase() {
  const Entry base = ago(filled_ - 1);
  for (Entry& entry : entries_) {
    entry.position -= base.position + base.velocity * core::seconds<T>(entry.at - base.at);
    entry.velocity -= base.velocity;
  }
}

template <typename T>
void PoseLatency<T>::add_pose(core::TimePoint captured, const Vector2& position_w_m) {
  if (sums_.count > 0 && captured - window_begin_ > kWindow) {
    close_window();
  }
  if (filled_ < 2) {
    return;
  }
  if (sums_.count == 0) {
    rebase();
    window_begin_ = captured;
    window_origin_ = position_w_m;
    tau_in_window_s_ = tau_s_ > static_cast<T>(kLookback_s) ? tau_s_ : static_cast<T>(kLookback_s);
  }
  Entry seen;
  if (!interpolate(captured - cut_to_microseconds(tau_in_window_s_), seen)) {
    return;
  }
  const T s = core::seconds<T>(captured - window_begin_) * static_cast<T>(1.0 / kHalfWindow_s) - T(1);
  const std::array<T, 3> power{T(1), s, s * s};
  for (std::size_t k = 0; k < 3; ++k) {
    sums_.power[k] += power[k];
  }
  sums_.power[3] += power[1] * power[2];
  sums_.power[4] += power[2] * power[2];
  const Vector2 remainder = position_w_m - window_origin_ - seen.position;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const T rate = -seen.velocity[static_cast<Eigen::Index>(axis)];
    const T z = remainder[static_cast<Eigen::Index>(axis)];
    for (std::size_t k = 0; k < 3; ++k) {
      sums_.by_rate[axis][k] += power[k] * rate;
      sums_.by_remainder[axis][k] += power[k] * z;
    }
    sums_.rate_rate[axis] += rate * rate;
    sums_.rate_remainder[axis] += rate * z;
    sums_.remainder_remainder[axis] += z * z;
  }
  ++sums_.count;
}

template <typename T>
void PoseLatency<T>::close_window() {
  const Elimination<T> elimination(sums_.power);
  if (sums_.count >= kFewest && elimination.positive()) {
    T rates = T(0), products = T(0), remainders = T(0);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const std::array<T, 3> g = elimination.solve(sums_.by_rate[axis]);
      const std::array<T, 3> z = elimination.solve(sums_.by_remainder[axis]);
      rates += sums_.rate_rate[axis] - dot(g, g);
      products += sums_.rate_remainder[axis] - dot(g, z);
      remainders += sums_.remainder_remainder[axis] - dot(z, z);
    }
    const T spare = static_cast<T>(2 * sums_.count - 7);
    const T left = (rates > T(0) ? remainders - products * products / rates : remainders) / spare;
    constexpr T kMin = static_cast<T>(kMinResidual_m * kMinResidual_m);
    const std::uint32_t by_time = sums_.count / kSamplesPerWindow;
    const T per_sample = static_cast<T>(by_time > kPosesPerSample ? by_time : kPosesPerSample);
    const T weight = T(1) / ((left > kMin ? left : kMin) * per_sample);
    if (rates > T(0)) {
      information_ = static_cast<T>(kMemoryPerWindow) * information_ + rates * weight;
      weighted_ = static_cast<T>(kMemoryPerWindow) * weighted_ + weight * (products + rates * tau_in_window_s_);
      update_estimate();
    }
  }
  sums_ = {};
}

template class PoseLatency<float>;
template class PoseLatency<double>;

}  // namespace m100::est
