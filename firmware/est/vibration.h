// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/consistency_status.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// The specific force above 15 Hz, where no motion of the aircraft lies: vibration, and the noise of the sensor. Two
/// high-passes of first order at the rate of the messages, by the bilinear transform, so that half that rate passes
/// whole. One alone lets through so much of a step that the step would widen what the checks allow.
///
/// No heap. Cost: a tangent and about 30 products a message. T is float or double.
template <typename T>
class Vibration {
 public:
  using Vector3 = core::Vector<T, 3>;

  /// Once per message. @param force_m_s2 forward, left, and upward without gravity. @param reading_m_s2 the largest of
  /// the sensor's own axes, with gravity. @param interval_s since the message before. @param memory_s of the means
  void update(const Vector3& force_m_s2, T reading_m_s2, T interval_s, T memory_s) {
    const T share = core::clamp(interval_s / memory_s, T(0), T(1));
    interval_s_ += (interval_s - interval_s_) * share;
    const T half_angle_rad = core::clamp(static_cast<T>(core::kPi * kCorner_hz) * interval_s, T(0.1), T(1.4));
    const T corner = core::tan(half_angle_rad);
    const T gain = T(1) / (T(1) + corner), pole = T(2) * gain - T(1);
    Vector3 high_m_s2 = force_m_s2;
    for (Stage& stage : stages_) {
      stage.out_m_s2 = gain * (high_m_s2 - stage.before_m_s2) + pole * stage.out_m_s2;
      stage.before_m_s2 = high_m_s2;
      high_m_s2 = stage.out_m_s2;
    }
    const T x2 = T(0.5) * high_m_s2.template head<2>().squaredNorm(), z2 = high_m_s2.z() * high_m_s2.z();
    variance_.horizontal += (x2 - variance_.horizontal) * share;
    variance_.vertical += (z2 - variance_.vertical) * share;
    const T to_density = interval_s / (gain * gain * (T(1) + T(0.5) * corner));  // what is left of white noise
    density_.horizontal += (x2 * to_density - density_.horizontal) * share;
    density_.vertical += (z2 * to_density - density_.vertical) * share;
    peak_m_s2_ -= peak_m_s2_ * share;
    const T now_m_s2 = high_m_s2.cwiseAbs().maxCoeff();
    peak_m_s2_ = now_m_s2 > peak_m_s2_ ? now_m_s2 : peak_m_s2_;
    const bool clips = reading_m_s2 >= static_cast<T>(kRange_g * model::kGravity_m_s2);
    clipped_ += ((clips ? T(1) : T(0)) - clipped_) * share;
  }

  /// Of one horizontal axis, and of the vertical one.
  struct Level {
    T horizontal{0};
    T vertical{0};
  };
  /// Density of white noise that leaves as much above 15 Hz; m^2/s^3.
  const Level& density_m2_s3() const { return density_; }
  /// Root mean square of one axis.
  T rms_m_s2() const {
    return core::sqrt((T(2) * variance_.horizontal + variance_.vertical) * static_cast<T>(1.0 / 3.0));
  }
  T peak_m_s2() const { return peak_m_s2_; }  ///< of one axis; fades
  /// Share of the messages in which an axis reads 8 g or more: sensors of autopilots are set to 8 or 16 g.
  T clipped() const { return clipped_; }
  /// Messages come at 30 Hz or less: 15 Hz cannot be seen in them.
  bool is_too_slow() const { return interval_s_ * T(2.0 * kCorner_hz) >= T(1); }
  /// Too slow: nothing is said of what is seen, and nothing ends by it.
  /// @param sum_memory_s of the velocity that ForceConsistency sums
  VibrationStatus status(T sum_memory_s) const {
    if (is_too_slow()) {
      return {.rms_m_s2 = std::numeric_limits<double>::quiet_NaN()};
    }
    return {.rms_m_s2 = static_cast<double>(rms_m_s2()),
            .peak_m_s2 = static_cast<double>(peak_m_s2_),
            .clipped = static_cast<double>(clipped_),
            .velocity_sigma_m_s = static_cast<double>(core::sqrt(density_.horizontal * T(0.5) * sum_memory_s))};
  }
  T magnitude() const { return density_.horizontal + density_.vertical + stages_.back().out_m_s2.squaredNorm(); }

 private:
  static constexpr double kCorner_hz = 15.0;
  static constexpr double kRange_g = 8.0;

  struct Stage {
    Vector3 before_m_s2 = Vector3::Zero();  ///< input of the message before
    Vector3 out_m_s2 = Vector3::Zero();
  };
  std::array<Stage, 2> stages_;
  Level variance_, density_;
  T peak_m_s2_{0}, clipped_{0};
  T interval_s_{0};  ///< mean
};

}  // namespace m100::est
