// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/est/estimate.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// A limit cycle as reported to the operator.
template <typename T>
struct LimitCycleReport {
  bool detected = false;
  T height_rad{0};    ///< of the highest of the counted half-waves, peak to peak
  T frequency_hz{0};  ///< of the last half-wave
};

/// Detects a limit cycle: a repeated oscillation of the tilt that neither the course nor the air causes. On each
/// horizontal axis the estimated tilt, minus the tilt for the reference's acceleration, is divided into half-waves,
/// from one turning point to the next. A limit cycle is detected if kHalfWaves consecutive half-waves meet all of these
/// conditions:
///   - higher than kMinHeight_rad, ten times the sigma of the tilt in a healthy hover;
///   - higher than the reference's own oscillation plus kMinRatio times the tilt that corresponds to the disturbance;
///   - kMinHalfWave_s to kMaxHalfWave_s long, which is 0.3 to 3 Hz;
///   - at least kMinHeightRatio times as high as the highest before it, and as long as the one before within a factor
///     kMaxPeriodRatio.
/// A jump of the reference restarts the count.
///
/// The disturbance is the observer's or the one by the following equation, whichever is larger. With x'' = g t + d,
///   s^2 / (s + a)^2 x  -  g / (s + a)^2 t  =  1 / (s + a)^2 d      (a = kFrom_per_s)
/// is true for any motion, and its left side needs only position x and tilt t. A healthy loop answers a disturbance
/// with a tilt of less than kMinRatio times its size.
///
/// At f Hz detection takes (kHalfWaves + 0.5) / 2 f from when the oscillation is high enough. Below 0.2 rad it may take
/// longer, because errors of poses and tilts count as a disturbance, too. Cost: some 60 operations per axis and tick,
/// no library function or heap. T is float or double.
template <typename T>
class LimitCycleDetector {
 public:
  static constexpr std::uint32_t kHalfWaves = 5;
  static constexpr std::uint32_t kHalfWavesAgain = 3;  ///< after pause(): one limit cycle has been detected already
  static constexpr double kMinHeight_rad = 0.1;
  static constexpr double kMinRatio = 5.0;
  static constexpr double kFrom_per_s = 6.0;
  static constexpr double kMinHalfWave_s = 0.5 / 3.0;
  static constexpr double kMaxHalfWave_s = 0.5 / 0.3;
  static constexpr double kMinHeightRatio = 0.7;
  static constexpr double kMaxPeriodRatio = 1.6;
  /// Jumps of the reference, in position and speed: smaller ones tilt the aircraft by less than two degrees.
  static constexpr double kJump_m = 0.02;
  static constexpr double kJump_m_s = 0.1;
  static constexpr double kStall_s = 0.025;  ///< a step of this length or longer begins the counting anew

  /// Once per tick. @param flies the law flies, and nothing else moves the sticks; if false, nothing is detected.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies, T step_s);
  /// Discards all half-waves and pauses for this time. Afterwards, until update() is called with flies = false,
  /// kHalfWavesAgain consecutive half-waves are enough.
  void pause(T time_s);

  /// The limit cycle of the axis that oscillates; if both do, that of the axis with the larger oscillation.
  LimitCycleReport<T> report() const;

 private:
  struct Range {
    T low{0};
    T high{0};
    void begin(T value) { low = high = value; }
    void add(T value) {
      low = value < low ? value : low;
      high = value > high ? value : high;
    }
    T size() const { return high - low; }
  };
  /// The motion in the detector's frequency band that the acceleration by tilt does not explain [m].
  struct UnexplainedMotion {
    T slow_m{0};
    T slower_m{0};
    T carried_m_s{0};
    T carried_m{0};
    T value_m{0};
    void begin(T position_m, T acceleration_m_s2);
    void update(T position_m, T acceleration_m_s2, T step_s);
  };
  struct Axis {
    bool rises = true;       ///< since the last turning point
    T turning_point_rad{0};  ///< tilt at the last turning point
    T age_s{0};              ///< since the last turning point
    T extreme_rad{0};        ///< highest (if it rises) or lowest tilt since the last turning point
    T extreme_age_s{0};      ///< since that extreme
    T height_rad{0};         ///< of the highest counted half-wave, or of the last one where none is counted
    T length_s{0};           ///< of the last half-wave
    std::uint32_t count{0};  ///< consecutive half-waves that meet the conditions
    T ref_position_m{0};     ///< of the tick before
    T ref_velocity_m_s{0};
    UnexplainedMotion unexplained;
    Range unexplained_m;  ///< since the last turning point
    Range disturbed_rad;  ///< the estimated disturbance, as a tilt
    Range reference_rad;  ///< the tilt that the reference's acceleration needs
  };
  void update_axis(Axis& axis, const est::AxisEstimate<T>& estimate, const ref::AxisReference<T>& reference, T sign,
                   T step_s) const;
  static bool jumps(Axis& axis, const ref::AxisReference<T>& reference, T step_s);
  static void turn(Axis& axis);

  Axis x_;
  Axis y_;
  std::uint32_t enough_ = kHalfWaves;
  T away_s_{0};
  bool watches_ = false;
};

extern template class LimitCycleDetector<float>;
extern template class LimitCycleDetector<double>;

}  // namespace m100::ctl
