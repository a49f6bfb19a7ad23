// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/specific_force.h"

namespace m100::est {
namespace {

/// The sensor's error is constant over a flight, the tilt's error varies within seconds.
constexpr double kBiasMemory_s = 20.0;
/// While force and poses disagree, one tick learns at most this difference: the rest may be a fault.
constexpr double kMaxSuspectOffset_m_s2 = 0.5;
/// A flight within 35 degrees of tilt measures 1 to 1.22 g in the mean; climb and gusts vary it.
constexpr double kMin_g = 0.8, kMax_g = 1.4;
/// Largest force that is used, in g or in m/s^2. A larger one is beyond any sensor's range, and its square could
/// overflow.
constexpr double kMaxForce = 400.0;
constexpr double kMovedLately_s = 1.0;

}  // namespace

template <typename T>
void SpecificForce<T>::update(const ImuSample<T>& imu) {
  const core::Vector<T, 3>& f = imu.force_b;
  if (!(f.squaredNorm() < static_cast<T>(kMaxForce * kMaxForce))) {
    return;
  }
  mean_b_ += (f - mean_b_) * (is_received() ? T(0.01) : T(1));
  const T size2 = mean_b_.squaredNorm();
  const auto about = [size2](double unit) {
    return size2 > static_cast<T>(kMin_g * unit * kMin_g * unit) &&
           size2 < static_cast<T>(kMax_g * unit * kMax_g * unit);
  };
  const T scale = about(1.0) ? static_cast<T>(model::kGravity_m_s2) : about(model::kGravity_m_s2) ? T(1) : T(0);
  scale_m_s2_ = scale;
  if (scale == T(0)) {
    learned_s_ = T(0);
    return;
  }
  const core::SinCos<T>& roll = imu.roll();
  const core::SinCos<T>& pitch = imu.pitch();
  const T upright = roll.sine * f.y() + roll.cosine * f.z();
  force_h_m_s2_ = Vector2(pitch.cosine * f.x() + pitch.sine * upright, roll.cosine * f.y() - roll.sine * f.z()) * scale;
  lifted_m_s2_ = (pitch.cosine * upright - pitch.sine * f.x()) * scale - static_cast<T>(model::kGravity_m_s2);
  tilt_acceleration_h_m_s2_ = core::heading_slope_of(roll, pitch) * static_cast<T>(model::kGravity_m_s2);
}

/// Learns the sensor's error, which is fixed to the body. It is turned with the tilt to first order; the second order,
/// at 20 degrees, is 6 % of an error.
template <typename T>
typename SpecificForce<T>::Unmeasured SpecificForce<T>::learn(const Vector2& change_h_m_s, T climbed_m_s, bool suspect,
                                                              T step_s) {
  const Vector2 measured_h_m_s2 = acceleration_h_m_s2();
  Unmeasured out{.change_h_m_s = change_h_m_s - measured_h_m_s2 * step_s, .learned_h_m_s = Vector2::Zero()};
  learned_s_ = core::clamp(learned_s_ + step_s, T(0), static_cast<T>(kBiasMemory_s));
  const T most = suspect ? static_cast<T>(kMaxSuspectOffset_m_s2) * step_s : T(1);
  const Vector2 limited_h = out.change_h_m_s.cwiseMax(-most).cwiseMin(most);
  const T share = T(1) / (learned_s_ > T(1) ? learned_s_ : T(1));
  out.learned_h_m_s = limited_h * share;
  const T unmeasured_up_m_s = climbed_m_s - vertical_acceleration_m_s2() * step_s;
  offset_up_m_s2_ += core::clamp(unmeasured_up_m_s, -most, most) * share;
  offset_h_m_s2_ += out.learned_h_m_s;
  average(measured_h_m_s2 + out.learned_h_m_s, step_s);
  return out;
}

template <typename T>
void SpecificForce<T>::average(const Vector2& acceleration_h_m_s2, T step_s) {
  mean_h_m_s2_ += (acceleration_h_m_s2 - mean_h_m_s2_) * (step_s * static_cast<T>(1.0 / kForceMean_s));
  const T moves_m_s2 = core::sqrt(mean_h_m_s2_.squaredNorm());
  moved_m_s2_ -= moved_m_s2_ * (step_s * static_cast<T>(1.0 / kMovedLately_s));
  moved_m_s2_ = moves_m_s2 > moved_m_s2_ ? moves_m_s2 : moved_m_s2_;
}

template <typename T>
T SpecificForce<T>::magnitude() const {
  return offset_h_m_s2_.squaredNorm() + mean_h_m_s2_.squaredNorm() + offset_up_m_s2_ * offset_up_m_s2_ + moved_m_s2_ +
         mean_b_.squaredNorm();
}

template <typename T>
[[gnu::cold]] void SpecificForce<T>::reset() {
  offset_h_m_s2_.setZero();
  mean_h_m_s2_.setZero();
  mean_b_.setZero();
  offset_up_m_s2_ = moved_m_s2_ = learned_s_ = T(0);
}

template class SpecificForce<float>;
template class SpecificForce<double>;

}  // namespace m100::est
