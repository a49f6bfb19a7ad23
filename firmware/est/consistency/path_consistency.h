// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/eigen.h"

namespace m100::est {

/// Result of one scale of PathConsistency, independent of the number of axes.
template <typename T>
struct PathStatistic {
  T seen_m2{0};           ///< largest recent w dot w, fading
  T drift_cusum_s{0};     ///< evidence that the path differs
  T likelihood_ratio{0};  ///< evidence that the pose does not respond to our motion, in nats
  T evidence{0};          ///< the larger of the two, as a share of its alarm threshold
  T residual_m{0};
  T allowed_m{0};
};

/// Compares the path of the poses with the path that the specific force implies, in metres. Hypothesis: the poses do
/// not follow the aircraft's motion.
///
/// Both paths pass the high-pass s^3 / (s + a)^3. The force is integrated twice, so it passes s / (s + a)^3. Constant
/// offsets, the initial position and the initial velocity therefore fade. Three scales run in parallel: a = 0.75, 1.5
/// and 3 1/s.
///
///   w  path of the observer's position, which accounts for the age and the gaps of the poses
///   y  path of the force
///   e  w - y, without the part that a wrong time of capture explains
///
/// Two one-sided sums give evidence:
///   follows  S' = (r^2 - 1) / 3, r = |e| / allowed; it finds a path that is turned, scaled, or begins to drift
///   answers  log likelihood ratio of two hypotheses: the pose does not depend on our motion, or the pose shows it; it
///            finds a pose that does not move, or that moves independently of the aircraft
///
/// With two axes this is the horizontal path. With one axis it is the height, in the two faster scales.
///
/// No heap. Cost: about 140 products and six square roots per tick, a third of it for one axis. T is float or double.
template <typename T, int kAxes = 2>
class PathConsistency {
 public:
  using Vector = core::Vector<T, kAxes>;

  /// Inputs of one tick, world frame. For kAxes = 1 they are those of the height.
  struct PathInput {
    Vector force_m_s2 = Vector::Zero();  ///< specific force
    Vector position_m = Vector::Zero();  ///< the observer's position
    Vector speed_m_s = Vector::Zero();   ///< the observer's velocity
    T position_sigma_m{0};               ///< one sigma of the position, as the observer reports it
    T position_noise_m2{0};              ///< measured variance of the white noise of one axis, per tick
    T force_noise_m2_s3{0};              ///< measured variance of the white noise times the time that a sample covers
    T tilt_acceleration_m2_s4{0};        ///< square of the acceleration by tilt beyond its mean; for the height only
    T turn_rad_s{0};                     ///< size of the yaw rate; for the horizontal only
  };

  /// Once per tick.
  /// @param pose_used a pose was used recently; in a gap the force continues the path, and no evidence is added
  void update(const PathInput& motion, bool pose_used, T step_s);
  /// Restarts both paths, after a motion that was not observed.
  void restart() {
    begun_ = false;
    for (Path& path : paths_) {
      path.evidence = T(0);
    }
  }

  /// The evidence, as a share of the threshold from which it contradicts the poses.
  T evidence() const { return worst().evidence; }
  /// The difference of the paths and its allowed value, in the scale with the most evidence; m.
  T residual_m() const { return worst().residual_m; }
  T allowed_m() const { return worst().allowed_m; }
  /// The difference of the paths in the middle scale, whose high-pass has the rate kApart_per_s.
  const Vector& apart_m() const { return apart_m_; }
  /// The middle scale had its turn in this tick.
  bool apart_is_new() const { return scale_index_ == 0; }
  static constexpr double kApart_per_s = 1.5;
  static constexpr std::size_t kScales = kAxes == 2 ? 3 : 2;

 private:
  struct Path : PathStatistic<T> {
    Vector mean_m_s2 = Vector::Zero();  ///< of the force
    Vector force_velocity_m_s = Vector::Zero();
    Vector force_position_m = Vector::Zero();
    std::array<Vector, 3> slow_m{Vector::Zero(), Vector::Zero(), Vector::Zero()};  ///< removed by each high-pass
    T late_m2_s{0};   ///< sum of e dot v; over moved_m2_s it is the error of the time of capture
    T moved_m2_s{0};  ///< sum of v dot v
  };
  const Path& worst() const {
    const Path& slower = paths_[0].evidence > paths_[kScales - 1].evidence ? paths_[0] : paths_[kScales - 1];
    return slower.evidence > paths_[1].evidence ? slower : paths_[1];
  }
  void begin(const PathInput& motion);
  Vector bridge_gap(const PathInput& motion, bool pose_used, T step_s);
  Vector correct_timing(std::size_t scale, const Vector& seen_m, T step_s);
  void accumulate(std::size_t scale, const Vector& seen_m, T speed_m_s, T step_s);
  Vector velocity_of(std::size_t scale) const;

  std::array<Path, kScales> paths_;
  Vector apart_m_ = Vector::Zero();
  bool begun_ = false;
  T since_gap_s_{0};
  T bridges_s_{0};                     ///< how long a gap is still bridged
  Vector speed_m_s_ = Vector::Zero();  ///< in the gap
  Vector position_m_ = Vector::Zero();
  Vector shift_m_ = Vector::Zero();  ///< from the observer's position to the bridged one
  T position_sigma_m_{0};            ///< the largest recent value, fading
  T tilt_acceleration_m_s2_{0};      ///< the largest recent value, fading
  T position_noise_m2_{0};           ///< newest input, less the part that the scales include
  T force_noise_m2_s3_{0};           ///< newest input, less the part that the scales include
  std::size_t scale_index_ = 0;      ///< the scale that is judged in this tick; the scales take turns
};

extern template class PathConsistency<float>;
extern template class PathConsistency<double>;
extern template class PathConsistency<float, 1>;
extern template class PathConsistency<double, 1>;

}  // namespace m100::est
