// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/eigen.h"

namespace m100::est {

/// What one scale of MotionCheck says, whatever its axes are.
template <typename T>
struct PathVerdict {
  T seen_m2{0};    ///< largest w dot w lately, fading
  T follows_s{0};  ///< evidence that the path is another
  T answers{0};    ///< evidence that the pose does not answer, in nats
  T evidence{0};   ///< the larger of the two, as a share of what contradicts
  T apart_m{0};
  T allowed_m{0};
};

/// Holds the path of the poses against the path that the specific force makes of itself, in metres.
///
/// Both paths pass the same high-pass of third order, s^3 / (s + a)^3: of a force that is all that is left of it after
/// two integrations, so that no offset has to be known (a constant one is forgotten), and a place and a speed have no
/// meaning. In three scales: the slow one (a = 0.75 1/s) sees what drifts for seconds, the middle one (a = 1.5 1/s)
/// what a hover moves by, above the rotors' noise, and the fast one (a = 3 1/s) has settled two seconds after the
/// start.
///
///   w  of the observer's position; y  of the force;  e = w - y
///
/// Two tests, each a one-sided sum:
///   follows  r = |e| / allowed, S' = (r^2 - 1) / 3, where allowed = noise + |v| tau + share |y|, and what the observer
///            is unsure of (v: y's velocity; what a wrong time of capture makes of it is fitted and taken away): a path
///            that is turned, scaled, or begins to drift
///   answers  (|e|^2 - |w|^2) / 2 sigma^2 - 1 for each axis per time of correlation, with sigma a third of the noise of
///            an axis: the logarithm of how much likelier it is that the pose knows nothing of our own motion than that
///            it shows it; an error in proportion to the motion (time, scale) is no evidence, and is not allowed for. A
///            body that stands still, or moves on its own
///
/// The observer's position serves, not the poses: it has their age and their gaps already in it.
///
/// Two axes: the horizontal path. One axis: the height, in the two faster scales; what drifts for longer, the
/// autopilot's climb speed tells better.
///
/// No heap. Cost: a tick about 140 products and six square roots, of one axis a third of it. T is float or double.
template <typename T, int kAxes = 2>
class MotionCheck {
 public:
  using Vector = core::Vector<T, kAxes>;

  /// What is known in a tick, in the world.
  struct Motion {
    Vector force_m_s2 = Vector::Zero();  ///< specific force
    Vector place_m = Vector::Zero();     ///< the observer's
    Vector speed_m_s = Vector::Zero();   ///< the observer's
    T unsure_m{0};                       ///< one sigma of the place, by the observer's account
    T place_noise_m2{0};                 ///< of an axis, white, as it was measured
    T force_noise_m2_s3{0};              ///< likewise: variance times the time for which a sample stands
    T leans_m2_s4{0};  ///< square of what the tilt accelerates with beyond its mean; upwards nothing else tells
  };

  /// Once per tick. @param sees a pose was used lately; in a gap the seen path goes on by the force, and nothing is
  /// evidence.
  void update(const Motion& motion, bool sees, T step_s);
  /// The paths begin anew: a motion that nobody looked at.
  void restart() {
    begun_ = false;
    for (Path& path : paths_) {
      path.evidence = T(0);
    }
  }

  /// How much evidence there is, as a share of what contradicts the poses.
  T evidence() const { return worst().evidence; }
  /// By how much the paths differ, and what is allowed, in the scale that shows it most; m.
  T apart_m() const { return worst().apart_m; }
  T allowed_m() const { return worst().allowed_m; }

 private:
  static constexpr std::size_t kScales = kAxes == 2 ? 3 : 2;
  struct Path : PathVerdict<T> {
    Vector mean_m_s2 = Vector::Zero();  ///< of the force
    Vector felt_m_s = Vector::Zero();
    Vector felt_m = Vector::Zero();
    std::array<Vector, 3> slow_m{Vector::Zero(), Vector::Zero(), Vector::Zero()};  ///< what each high-pass takes away
    T late_m2_s{0};   ///< e dot v, summed: with moved_m2_s what the time of capture is wrong by
    T moved_m2_s{0};  ///< v dot v
  };
  const Path& worst() const {
    const Path& slower = paths_[0].evidence > paths_[kScales - 1].evidence ? paths_[0] : paths_[kScales - 1];
    return slower.evidence > paths_[1].evidence ? slower : paths_[1];
  }
  void begin(const Motion& motion);
  Vector bridged(const Motion& motion, bool sees, T step_s);
  Vector timed(std::size_t scale, const Vector& seen_m, T step_s);
  void judge(std::size_t scale, const Vector& seen_m, T speed_m_s, T step_s);
  Vector velocity_of(std::size_t scale) const;

  std::array<Path, kScales> paths_;
  bool begun_ = false;
  T since_gap_s_{0};
  T bridges_s_{0};                     ///< how long a gap is still bridged
  Vector speed_m_s_ = Vector::Zero();  ///< in the gap
  Vector place_m_ = Vector::Zero();
  Vector shift_m_ = Vector::Zero();  ///< from the observer's place to the bridged one
  T unsure_m_{0};                    ///< the largest lately, fading
  T leans_m_s2_{0};                  ///< likewise
  T place_noise_m2_{0};              ///< as told last
  T force_noise_m2_s3_{0};           ///< likewise, beyond what the scales have in them
  std::size_t turn_ = 0;             ///< the scale that is judged in this tick; the other one is in the next
};

extern template class MotionCheck<float>;
extern template class MotionCheck<double>;
extern template class MotionCheck<float, 1>;
extern template class MotionCheck<double, 1>;

}  // namespace m100::est
