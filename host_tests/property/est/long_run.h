// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "firmware/est/filter/axis_filter.h"

namespace m100::est {

/// Deviation of one arithmetic from double over a long flight of one axis.
struct ScalarReport {
  double position_rms_m = 0.0, position_max_m = 0.0;
  double velocity_rms_m_s = 0.0;
  double disturbance_rms_m_s2 = 0.0, disturbance_max_m_s2 = 0.0;
  long not_positive = 0;  ///< number of covariances, checked once a second, that are not positive definite
  long refused = 0;       ///< refused poses
};

struct LongRunReport {
  ScalarReport fixed, single;
  long not_positive_double = 0;
  double disturbance_error_rms_m_s2 = 0.0;  ///< error of the double filter against the true value
};

/// The measured axis: 9.36 rad/s, damping 0.68, 33 ms.
inline AxisModel measured_axis() {
  AxisModel model;
  model.attitude = {.natural_frequency_rad_s = 9.36, .damping_ratio = 0.68, .transport_delay_s = 0.033};
  model.linear_drag_per_s = 0.3;
  model.noise.velocity_process_m_s = 0.005;
  model.noise.tilt_rate_process_rad_s = 0.3;
  model.noise.disturbance_process_m_s2 = 0.15;
  return model;
}

namespace detail {

/// Whether the covariance is positive definite, by a Cholesky factorisation in double.
template <typename S>
bool positive(const AxisFilter<S>& filter) {
  constexpr int kN = AxisFilter<S>::kStates;
  core::Matrix<double, kN, kN> covariance;
  for (int i = 0; i < kN; ++i) {
    for (int j = 0; j < kN; ++j) {
      covariance(i, j) = static_cast<double>(filter.covariance(i, j));
    }
  }
  return covariance.llt().info() == Eigen::Success;
}

template <typename S>
struct Runner {
  explicit Runner(const AxisModel& model) : filter(model) {}
  AxisFilter<S> filter;
  double since_pose_s = 0.0;
  long refused = 0;
  void tick(double u, double before, double after, bool pose, double position, double age_s, double tilt, double rate) {
    filter.predict({.now = S(u), .before = S(before), .after = S(after)});
    filter.fuse_attitude(S(tilt), S(rate), S(0.002));
    since_pose_s += kTick_s;
    if (pose) {
      // As in DisturbanceEkf: the gate is widened by the motion that wind may have caused without a pose.
      const double unseen_m = std::fmin(0.5, 1.5 * since_pose_s * since_pose_s);
      const auto test = filter.test_pose(S(position), S(age_s), S(unseen_m), S(0));
      if (test.inside) {
        filter.fuse_pose(test);
        since_pose_s = 0.0;
      } else {
        ++refused;
      }
    }
  }
  double state(int i) const {
    return static_cast<double>(filter.state(static_cast<typename AxisFilter<S>::StateIndex>(i)));
  }
};

template <typename S>
void compare(const Runner<S>& other, const Runner<double>& reference, ScalarReport& report) {
  const double dp = other.state(0) - reference.state(0);
  const double dv = other.state(1) - reference.state(1);
  const double dd = other.state(4) - reference.state(4);
  report.position_rms_m += dp * dp;
  report.velocity_rms_m_s += dv * dv;
  report.disturbance_rms_m_s2 += dd * dd;
  report.position_max_m = std::fmax(report.position_max_m, std::fabs(dp));
  report.disturbance_max_m_s2 = std::fmax(report.disturbance_max_m_s2, std::fabs(dd));
}

/// Inputs of the filters in one tick, and the true state.
struct WanderTick {
  double u, before, after;  ///< rad, as the delay line gives them
  bool pose;
  double seen, age_s, tilt_seen, rate_seen;
  double wind;
};

/// The wandering vehicle and its sensors.
class Wander {
 public:
  Wander(const AxisModel& model, std::uint32_t seed)
      : step_(model::axis_step(model.attitude, kTick_s)), random_(seed) {}

  WanderTick tick(long tick) {
    // Delay 3.3 ticks: 0.7 of the input sent 3 ticks ago and 0.3 of the one 4 ticks ago.
    const auto delayed = [&](std::size_t more) { return 0.7 * sent_[3 + more] + 0.3 * sent_[4 + more]; };
    WanderTick out{};
    out.u = delayed(0);
    out.before = delayed(1);
    out.after = 0.7 * sent_[2] + 0.3 * sent_[3];
    move(out);
    const double t = 0.01 * static_cast<double>(tick);
    positions_[static_cast<std::size_t>(tick) % positions_.size()] = position_;
    const long age_ticks = 1 + static_cast<long>(random_() % 3);
    const bool dropout = std::fmod(t, 30.0) < 0.3;
    out.pose = tick > 8 && !dropout && random_() % 50 != 0;
    out.seen = positions_[static_cast<std::size_t>(tick - (tick > 3 ? age_ticks : 0)) % positions_.size()] +
               0.002 * normal_(random_);
    out.tilt_seen = tilt_ - 0.002 * rate_ + 0.005 * normal_(random_);
    out.rate_seen = rate_ + 0.01 * normal_(random_);
    out.age_s = 0.01 * static_cast<double>(age_ticks);
    return out;
  }

  /// A simple position loop on the estimate of one filter.
  void steer(double position, double velocity, long tick) {
    const double t = 0.01 * static_cast<double>(tick);
    const double goal = 2.0 * std::sin(0.5 * t) + 1.0;
    const double wanted = -0.35 * (position - goal) - 0.35 * (velocity - std::cos(0.5 * t)) - 0.09;
    for (std::size_t i = sent_.size() - 1; i > 0; --i) {
      sent_[i] = sent_[i - 1];
    }
    sent_[0] = std::fmax(-0.43, std::fmin(0.43, wanted));
  }

 private:
  void move(WanderTick& out) {
    constexpr double kTrim = 0.02;
    const double old_tilt = tilt_, old_rate = rate_;
    tilt_ = step_.oo * old_tilt + step_.o_r * old_rate + step_.o_u * (out.u + kTrim);
    rate_ = step_.ro * old_tilt + step_.rr * old_rate + step_.r_u * (out.u + kTrim);
    gust_ = 0.99 * gust_ + 0.5 * std::sqrt(1.0 - 0.99 * 0.99) * normal_(random_);
    out.wind = 1.0 + gust_;
    const double acceleration = 9.8066 * std::tan(0.5 * (tilt_ + old_tilt)) - 0.3 * velocity_ + out.wind;
    position_ += 0.01 * velocity_ + 5e-5 * acceleration;
    velocity_ += 0.01 * acceleration;
  }

  model::AxisStep step_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::array<double, 64> positions_{};
  std::array<double, 8> sent_{};
  double position_ = 0.0, velocity_ = 0.0, tilt_ = 0.0, rate_ = 0.0, gust_ = 0.0;
};

template <typename S>
void update(Runner<S>& runner, const WanderTick& tick) {
  runner.tick(tick.u, tick.before, tick.after, tick.pose, tick.seen, tick.age_s, tick.tilt_seen, tick.rate_seen);
}

template <typename S>
void count_not_positive(const AxisFilter<S>& filter, long& count) {
  count += positive(filter) ? 0 : 1;
}

template <typename S>
void finish(const Runner<S>& runner, double count, ScalarReport& report) {
  report.position_rms_m = std::sqrt(report.position_rms_m / count);
  report.velocity_rms_m_s = std::sqrt(report.velocity_rms_m_s / count);
  report.disturbance_rms_m_s2 = std::sqrt(report.disturbance_rms_m_s2 / count);
  report.refused = runner.refused;
}

}  // namespace detail

/// A flight that wanders within a few metres under a simple position loop in gusty wind. Poses have 2 mm noise and are
/// 15 to 35 ms old; one in fifty is lost, and dropouts of 0.3 s occur twice a minute. Attitudes have 0.3 degrees noise.
/// All three filters get the same inputs.
inline LongRunReport long_run(double hours, std::uint32_t seed) {
  using Filter = AxisFilter<double>;
  const AxisModel model = measured_axis();
  detail::Runner<double> reference(model);
  detail::Runner<float> single(model);
  detail::Runner<core::Fixed> fixed(model);
  detail::Wander wander(model, seed);
  const long ticks = std::lround(hours * 360000.0);
  constexpr long kConvergedTicks = 1000;
  LongRunReport report;
  for (long tick = 0; tick < ticks; ++tick) {
    const detail::WanderTick measured = wander.tick(tick);
    detail::update(reference, measured);
    detail::update(single, measured);
    detail::update(fixed, measured);
    wander.steer(reference.state(Filter::kP), reference.state(Filter::kV), tick);
    if (tick > kConvergedTicks) {
      detail::compare(fixed, reference, report.fixed);
      detail::compare(single, reference, report.single);
      const double error = reference.state(Filter::kD) - measured.wind;
      report.disturbance_error_rms_m_s2 += error * error;
    }
    if (tick % 100 == 0) {
      detail::count_not_positive(fixed.filter, report.fixed.not_positive);
      detail::count_not_positive(single.filter, report.single.not_positive);
      detail::count_not_positive(reference.filter, report.not_positive_double);
    }
  }
  const double n = static_cast<double>(ticks - kConvergedTicks - 1);
  detail::finish(fixed, n, report.fixed);
  detail::finish(single, n, report.single);
  report.disturbance_error_rms_m_s2 = std::sqrt(report.disturbance_error_rms_m_s2 / n);
  return report;
}

}  // namespace m100::est
