// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/path_consistency.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

/// The sensor's offset that a tilt turns into the horizontal, as a share of the acceleration by this tilt: 0.2 m/s^2
/// per g.
constexpr double kOffsetPerAcceleration = 0.2 / 9.8066;

/// One scale of the high-pass. The noise of the rotors, 0.1 m/s^2 per sample of 10 ms, leaves
/// 0.1 m/s^2 sqrt(0.01 s / 16 a^3) in a path. An attitude error of 0.1 degrees leaves 0.27 / a^2 times 0.02 m/s^2. The
/// observer's position is accurate to 2 mm.
template <typename T>
struct Scale {
  T a_per_s;
  T sigma_m;       ///< about sqrt(noise^2 + (attitude / 3)^2 + (2 mm / 3)^2)
  T unsettled_m;   ///< 0.25 m/s of error in speed, times 0.23 / a, plus 0.05 m/s^2 in the offset, times 0.27 / a^2;
                   ///< is multiplied by 1 + |speed|: a gap in the poses hides more of a faster motion
  T per_noise_s3;  ///< 1 / 16 a^3: variance of the path per density of the force's noise
  T tilt_gain_s2;  ///< 0.27 / a^2 times kOffsetPerAcceleration
};
template <typename T>
constexpr std::array<Scale<T>, 3> kScaleNumbers{{{T(1.5), T(0.0017), T(0.044), T(0.0185), T(0.0024)},
                                                 {T(3.0), T(0.0010), T(0.021), T(0.0023), T(0.0006)},
                                                 {T(0.75), T(0.0052), T(0.10), T(0.148), T(0.0098)}}};
static_assert(kScaleNumbers<double>[0].a_per_s == PathConsistency<double>::kApart_per_s);
constexpr bool within_4_percent(double number, double rule) { return number > 0.96 * rule && number < 1.04 * rule; }
constexpr bool follows_from_a(const Scale<double>& s) {
  const double per_a = 1.0 / s.a_per_s, per_a2 = per_a * per_a;
  return within_4_percent(s.unsettled_m, 0.25 * 0.23 * per_a + 0.05 * 0.27 * per_a2) &&
         within_4_percent(s.per_noise_s3, per_a2 * per_a / 16.0) &&
         within_4_percent(s.tilt_gain_s2, 0.27 * per_a2 * kOffsetPerAcceleration);
}
static_assert(follows_from_a(kScaleNumbers<double>[0]) && follows_from_a(kScaleNumbers<double>[1]) &&
              follows_from_a(kScaleNumbers<double>[2]));
/// Noise of the force that the scales already include: the rotors' 0.1 m/s^2, and half as much again because it is
/// measured from few samples.
constexpr double kAssumed_m2_s3 = 1.5e-4;
/// White noise of the poses leaves in each axis of a path 1.4 times the correction that it makes to the observer per
/// tick. The scales already include poses that scatter by 1 mm, which correct the height by 0.5 mm.
constexpr double kPositionNoiseGain2 = 2.0, kAssumed_m2 = 2.5e-7;
/// Memory of the largest recent acceleration. It bounds the part of the sensor's offset that a change of the tilt turns
/// into the horizontal.
constexpr double kTiltMemory_s = 2.0;
/// Transients of the start or of a gap have faded after this many times 1 / a.
constexpr double kSettles = 4.0;
/// Three sigmas: of one axis, squared; and as a distance over all axes, 3 sqrt(kAxes).
constexpr double kSigmas2 = 9.0;
template <int kAxes>
constexpr double kSigmas = kAxes == 2 ? 4.24 : 3.0;
/// Allowed share of the path: the heading of the markers is right within 3 degrees, the scale of the force within 2 %.
constexpr double kShare = 0.07;
/// Attitude, force and pose may be this far apart in time: a tick and two pose intervals.
constexpr double kTime_s = 0.03;
/// Memory, prior (one sigma) and limit of the error of the time of capture, which is fitted to the motion.
constexpr double kLateMemory_s = 5.0, kLate_s = 0.05, kMaxLate_s = 0.12;
/// Memory of the largest recent sigma of the observer's position.
constexpr double kSigmaMemory_s = 1.0;
constexpr double kForever_s = 100.0;
constexpr double kGapCorrection_s = 0.3;  ///< time in which the observer corrects its error after a gap
constexpr double kFollows_s = 0.25;       ///< alarm: twice the allowed difference for a quarter of a second
constexpr double kMaxWeight = 4.0;
/// For a healthy pose |e|^2 / (2 sigma^2) of two axes is exponentially distributed with mean 1. With 2 subtracted per
/// correlation time 1 / a, the sum reaches h with a probability of at most exp(-0.797 h), 0.797 being the root of
/// exp(-2 x) = 1 - x. At 16 that is once in 15 000 flights of half a minute.
constexpr double kNats = 16.0;
constexpr double kDrift_nats = 1.0;  ///< per axis
constexpr double kSane_m2 = 1e9;
constexpr double kMaxNats = 20.0;  ///< per time of correlation: one gross outlier is never enough

/// The numbers of a path in one tick, independent of the number of axes.
template <typename T>
struct TickTerms {
  T apart2_m2, moved2_m2, noise_m, allowed_m;
  T a_s;  ///< the step as a share of a time of correlation
  T step_s;
  int axes;
  bool bridges;  ///< in a gap of the poses: no evidence is added
  bool settled;
};

template <typename T>
void add_evidence(const TickTerms<T>& terms, PathStatistic<T>& path) {
  const T weight =
      core::clamp((terms.apart2_m2 / (terms.allowed_m * terms.allowed_m) - T(1)) * static_cast<T>(1.0 / 3.0), T(-1),
                  static_cast<T>(kMaxWeight));
  path.drift_cusum_s = core::clamp(path.drift_cusum_s + (terms.bridges ? T(0) : weight * terms.step_s), T(0),
                                   static_cast<T>(2.0 * kFollows_s));
  // The largest recent path fades at the rate a / 2 in the horizontal, where motion turns back slowly, at a in height.
  const T fades = (terms.axes == 2 ? T(0.5) : T(1)) * terms.a_s;
  path.seen_m2 += (terms.moved2_m2 - path.seen_m2) * fades;
  path.seen_m2 = terms.moved2_m2 > path.seen_m2 ? terms.moved2_m2 : path.seen_m2;  // w itself passes through zero
  if (terms.settled) {
    const T axes = static_cast<T>(terms.axes);
    const T per_sigma2 = static_cast<T>(0.5 * kSigmas2) * axes / (terms.noise_m * terms.noise_m);
    const T nats = core::clamp((terms.apart2_m2 - path.seen_m2) * per_sigma2 - static_cast<T>(kDrift_nats) * axes,
                               static_cast<T>(-kMaxNats), static_cast<T>(kMaxNats));
    path.likelihood_ratio = core::clamp(path.likelihood_ratio + nats * terms.a_s, T(0), static_cast<T>(1.5 * kNats));
  }
  const T drift = path.drift_cusum_s * static_cast<T>(1.0 / kFollows_s);
  const T likelihood_ratio = path.likelihood_ratio * static_cast<T>(1.0 / kNats);
  path.evidence = drift > likelihood_ratio ? drift : likelihood_ratio;
  path.residual_m = core::sqrt(terms.apart2_m2);
  path.allowed_m = drift > likelihood_ratio ? terms.allowed_m : terms.noise_m;
}

}  // namespace

/// Starts as if the present speed had been constant for ever, so that it causes no transient.
template <typename T, int kAxes>
void PathConsistency<T, kAxes>::begin(const PathInput& motion) {
  shift_m_.setZero();
  bridges_s_ = since_gap_s_ = position_sigma_m_ = tilt_acceleration_m_s2_ = T(0);
  begun_ = true;
  for (std::size_t scale = 0; scale < kScales; ++scale) {
    const T time_s = T(1) / kScaleNumbers<T>[scale].a_per_s;
    paths_[scale] = {};
    paths_[scale].slow_m[0] = motion.position_m - motion.speed_m_s * time_s;
    paths_[scale].slow_m[1] = motion.speed_m_s * time_s;
  }
}

/// The difference of the two paths without the part that a wrong time of capture explains, found by least squares over
/// the last seconds. A wrong time explains neither a path that does not move nor one that is unrelated.
template <typename T, int kAxes>
typename PathConsistency<T, kAxes>::Vector PathConsistency<T, kAxes>::correct_timing(std::size_t scale,
                                                                                     const Vector& seen_m, T step_s) {
  const Scale<T>& s = kScaleNumbers<T>[scale];
  Path& path = paths_[scale];
  const Vector velocity_m_s = velocity_of(scale);
  const Vector residual_m = seen_m - path.force_position_m;
  const T fades = step_s * static_cast<T>(1.0 / kLateMemory_s);
  path.late_m2_s += residual_m.dot(velocity_m_s) * step_s - path.late_m2_s * fades;
  path.moved_m2_s += velocity_m_s.squaredNorm() * step_s - path.moved_m2_s * fades;
  const T known_m2_s = s.sigma_m * s.sigma_m / (s.a_per_s * static_cast<T>(kLate_s * kLate_s));
  const T late_s = core::clamp(path.late_m2_s / (path.moved_m2_s + known_m2_s), static_cast<T>(-kMaxLate_s),
                               static_cast<T>(kMaxLate_s));
  return residual_m - velocity_m_s * late_s;
}

template <typename T, int kAxes>
void PathConsistency<T, kAxes>::accumulate(std::size_t scale, const Vector& seen_m, T speed_m_s, T step_s) {
  const Scale<T>& s = kScaleNumbers<T>[scale];
  Path& path = paths_[scale];
  const Vector apart_m = correct_timing(scale, seen_m, step_s);
  const T apart2_m2 = apart_m.squaredNorm();
  if (!(apart2_m2 + path.moved_m2_s < static_cast<T>(kSane_m2))) {
    begun_ = false;  // a path that is not finite would never raise an alarm
    return;
  }
  apart_m_ = scale == 0 ? apart_m : apart_m_;
  const T settled = core::clamp(since_gap_s_ * s.a_per_s * static_cast<T>(1.0 / kSettles), T(0), T(1));
  const T sigma_m = core::sqrt(s.sigma_m * s.sigma_m + static_cast<T>(kPositionNoiseGain2) * position_noise_m2_ +
                               s.per_noise_s3 * force_noise_m2_s3_);
  const T noise_m = static_cast<T>(kSigmas<kAxes>) * sigma_m + s.unsettled_m * (T(1) - settled) * (T(1) + speed_m_s) +
                    position_sigma_m_ + s.tilt_gain_s2 * tilt_acceleration_m_s2_;
  const T moving_m = static_cast<T>(kTime_s) * core::sqrt(velocity_of(scale).squaredNorm()) +
                     static_cast<T>(kShare) * core::sqrt(path.force_position_m.squaredNorm());
  const TickTerms<T> terms{.apart2_m2 = apart2_m2,
                           .moved2_m2 = seen_m.squaredNorm(),
                           .noise_m = noise_m,
                           .allowed_m = noise_m + moving_m,
                           .a_s = s.a_per_s * step_s,
                           .step_s = step_s,
                           .axes = kAxes,
                           .bridges = bridges_s_ > T(0),
                           .settled = settled >= T(1)};
  add_evidence(terms, path);
}

template <typename T, int kAxes>
typename PathConsistency<T, kAxes>::Vector PathConsistency<T, kAxes>::velocity_of(std::size_t scale) const {
  return paths_[scale].force_velocity_m_s - paths_[scale].force_position_m * kScaleNumbers<T>[scale].a_per_s;
}

/// @returns the position of the pose path; the force continues it over a gap of the poses and kGapCorrection_s beyond
template <typename T, int kAxes>
typename PathConsistency<T, kAxes>::Vector PathConsistency<T, kAxes>::bridge_gap(const PathInput& motion,
                                                                                 bool pose_used, T step_s) {
  if (!pose_used && bridges_s_ <= T(0)) {
    speed_m_s_ = motion.speed_m_s;
    position_m_ = motion.position_m + shift_m_;
  }
  bridges_s_ = pose_used ? bridges_s_ - step_s : static_cast<T>(kGapCorrection_s);
  if (bridges_s_ > T(0)) {
    speed_m_s_ += motion.force_m_s2 * step_s;
    position_m_ += speed_m_s_ * step_s;
    shift_m_ = position_m_ - motion.position_m;
    since_gap_s_ = T(0);
  }
  since_gap_s_ = core::clamp(since_gap_s_ + step_s, T(0), static_cast<T>(kForever_s));
  return motion.position_m + shift_m_;
}

template <typename T, int kAxes>
void PathConsistency<T, kAxes>::update(const PathInput& motion, bool pose_used, T step_s) {
  if (!begun_) {
    begin(motion);
  }
  const Vector position_m = bridge_gap(motion, pose_used, step_s);
  const T speed_m_s = core::sqrt(motion.speed_m_s.squaredNorm());
  position_sigma_m_ -= position_sigma_m_ * (step_s * static_cast<T>(1.0 / kSigmaMemory_s));
  position_sigma_m_ = motion.position_sigma_m > position_sigma_m_ ? motion.position_sigma_m : position_sigma_m_;
  position_noise_m2_ = core::clamp(motion.position_noise_m2 - static_cast<T>(kAssumed_m2), T(0), T(1));
  force_noise_m2_s3_ = core::clamp(motion.force_noise_m2_s3 - static_cast<T>(kAssumed_m2_s3), T(0), T(1));
  const T moved_m2_s4 = paths_[1].mean_m_s2.squaredNorm();  // without the rotors' vibration
  // In a turn the force comes into the world by a heading that is wrong by the yaw rate times kTime_s.
  const T by_turn = T(1) + motion.turn_rad_s * static_cast<T>(kTime_s / kOffsetPerAcceleration);
  const T tilt_acceleration_m_s2 =
      by_turn * core::sqrt(motion.tilt_acceleration_m2_s4 > moved_m2_s4 ? motion.tilt_acceleration_m2_s4 : moved_m2_s4);
  tilt_acceleration_m_s2_ -= tilt_acceleration_m_s2_ * (step_s * static_cast<T>(1.0 / kTiltMemory_s));
  tilt_acceleration_m_s2_ =
      tilt_acceleration_m_s2 > tilt_acceleration_m_s2_ ? tilt_acceleration_m_s2 : tilt_acceleration_m_s2_;
  scale_index_ = (scale_index_ + 1) % kScales;
  for (std::size_t scale = 0; scale < kScales; ++scale) {
    Path& path = paths_[scale];
    const T a_per_s = kScaleNumbers<T>[scale].a_per_s;
    const T share = a_per_s * step_s;
    path.mean_m_s2 += (motion.force_m_s2 - path.mean_m_s2) * share;
    path.force_velocity_m_s += (motion.force_m_s2 - path.mean_m_s2 - path.force_velocity_m_s * a_per_s) * step_s;
    path.force_position_m += (path.force_velocity_m_s - path.force_position_m * a_per_s) * step_s;
    Vector seen_m = position_m;
    for (Vector& slow_m : path.slow_m) {
      slow_m += (seen_m - slow_m) * share;
      seen_m -= slow_m;
    }
    if (scale == scale_index_) {
      accumulate(scale, seen_m, speed_m_s, static_cast<T>(kScales) * step_s);
    }
  }
}

template class PathConsistency<float>;
template class PathConsistency<double>;
template class PathConsistency<float, 1>;
template class PathConsistency<double, 1>;

}  // namespace m100::est
