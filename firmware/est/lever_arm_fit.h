// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"

namespace m100::est {

/// Whether the paths of pose and force differ because the pose's origin lies beside the centre of gravity: by the lever
/// arm a (forward and left), the difference is e = R(yaw) a, high-passed as both paths. With h = (c, s), cosine and
/// sine of the heading after that high-pass, least squares give
///   a_x = sum(c e_x + s e_y) / sum(h h),  a_y = sum(c e_y - s e_x) / sum(h h)
/// and a explains the share |a|^2 sum(h h) / sum(e e) of the difference.
///
/// No heap. Cost: about 30 products per call. T is float or double.
template <typename T>
class LeverArmFit {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// @param apart_m e, of a path with the high-pass s^3 / (s + a_per_s)^3
  /// @param new_s since the e before; 0: this is still that one, and only the heading passes on
  void update(const core::SinCos<T>& heading, const Vector2& apart_m, T a_per_s, T step_s, T new_s) {
    Vector2 h(heading.cosine, heading.sine);
    if (!begun_) {
      *this = {};
      begun_ = true;
      slow_[0] = h;
    }
    for (Vector2& slow : slow_) {
      slow += (h - slow) * (a_per_s * step_s);
      h -= slow;
    }
    const T share = new_s * static_cast<T>(1.0 / kMemory_s);
    const Vector2 along_m(h.dot(apart_m), h.x() * apart_m.y() - h.y() * apart_m.x());
    product_m_ += (along_m - product_m_) * share;
    turned_ += (h.squaredNorm() - turned_) * share;
    apart_m2_ += (apart_m.squaredNorm() - apart_m2_) * share;
  }
  /// The next difference is that of a path that begins anew.
  void restart() { begun_ = false; }
  /// Mean square of h: how much it has turned in the last seconds, 1 at most. One sigma of the lever arm is that of the
  /// paths' difference, divided by the root of this.
  T turned() const { return turned_; }
  /// The length of a lever arm that would explain the whole difference.
  T longest_m() const { return core::sqrt(apart_m2_ / turned_); }
  /// The lever arm, forward and left; zero: it explains less than nine tenths of the difference, or is longer than 1 m.
  Vector2 lever_b_m() const {
    const T explained_m2 = product_m_.squaredNorm();
    const bool is_known =
        explained_m2 > static_cast<T>(kExplains) * turned_ * apart_m2_ && explained_m2 < turned_ * turned_;
    return is_known ? Vector2(product_m_ / turned_) : Vector2(Vector2::Zero());
  }

 private:
  static constexpr double kMemory_s = 2.0;  ///< a turn by 90 degrees
  static constexpr double kExplains = 0.9;  ///< then one sigma of the lever arm is at most a third of it

  bool begun_ = false;
  std::array<Vector2, 3> slow_{Vector2::Zero(), Vector2::Zero(), Vector2::Zero()};  ///< removed by each high-pass
  Vector2 product_m_ = Vector2::Zero();  ///< mean of h times e, in the axes of the body
  T turned_{0};                          ///< mean of h h
  T apart_m2_{0};                        ///< mean of e e
};

}  // namespace m100::est
