// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/eigen.h"

namespace m100::est {

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
///   answers  (|e|^2 - |w|^2) / 2 sigma^2 - 2 per time of correlation, with sigma = allowed / 4.2: the logarithm of
///            how much likelier it is that the pose knows nothing of our own motion than that it shows it; an error in
///            proportion to the motion (time, scale) is no evidence. A body that stands still, or moves on its own
///
/// The observer's position serves, not the poses: it has their age and their gaps already in it.
///
/// No heap. Cost: a tick about 140 products and six square roots. T is float or double.
template <typename T>
class MotionCheck {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// What is known in a tick, in the world.
  struct Motion {
    Vector2 force_m_s2 = Vector2::Zero();  ///< specific force, horizontal
    Vector2 place_m = Vector2::Zero();     ///< the observer's
    Vector2 speed_m_s = Vector2::Zero();   ///< the observer's
    T unsure_m{0};                         ///< one sigma of the place, by the observer's account
  };

  /// Once per tick. @param sees a pose was used lately; in a gap the seen path goes on by the force, and nothing is
  /// evidence.
  void update(const Motion& motion, bool sees, T step_s);
  /// The paths begin anew: a motion that nobody looked at.
  void restart() {
    begun_ = false;
    paths_ = {};
  }

  /// How much evidence there is, as a share of what contradicts the poses.
  T evidence() const { return worst().evidence; }
  /// By how much the paths differ, and what is allowed, in the scale that shows it most; m.
  T apart_m() const { return worst().apart_m; }
  T allowed_m() const { return worst().allowed_m; }

 private:
  static constexpr std::size_t kScales = 3;
  struct Path {
    Vector2 mean_m_s2 = Vector2::Zero();  ///< of the force
    Vector2 felt_m_s = Vector2::Zero();
    Vector2 felt_m = Vector2::Zero();
    std::array<Vector2, 3> slow_m{Vector2::Zero(), Vector2::Zero(),
                                  Vector2::Zero()};  ///< what each high-pass takes away
    T late_m2_s{0};   ///< e dot v, summed: with moved_m2_s what the time of capture is wrong by
    T moved_m2_s{0};  ///< v dot v
    T seen_m2{0};     ///< largest w dot w lately, fading
    T follows_s{0};   ///< evidence that the path is another
    T answers{0};     ///< evidence that the pose does not answer, in nats
    T evidence{0};    ///< the larger of the two, as a share of what contradicts
    T apart_m{0};
    T allowed_m{0};
  };
  const Path& worst() const {
    const Path& slower = paths_[0].evidence > paths_[2].evidence ? paths_[0] : paths_[2];
    return slower.evidence > paths_[1].evidence ? slower : paths_[1];
  }
  void begin(const Motion& motion);
  Vector2 bridged(const Motion& motion, bool sees, T step_s);
  Vector2 timed(std::size_t scale, const Vector2& seen_m, T step_s);
  void judge(std::size_t scale, const Vector2& seen_m, T speed_m_s, T step_s);
  Vector2 velocity_of(std::size_t scale) const;

  std::array<Path, kScales> paths_;
  bool begun_ = false;
  T since_gap_s_{0};
  T bridges_s_{0};                       ///< how long a gap is still bridged
  Vector2 speed_m_s_ = Vector2::Zero();  ///< in the gap
  Vector2 place_m_ = Vector2::Zero();
  Vector2 shift_m_ = Vector2::Zero();  ///< from the observer's place to the bridged one
  T unsure_m_{0};                      ///< the largest lately, fading
  T leans_m_s2_{0};                    ///< likewise
  std::size_t turn_ = 0;               ///< the scale that is judged in this tick; the other one is in the next
};

extern template class MotionCheck<float>;
extern template class MotionCheck<double>;

}  // namespace m100::est
