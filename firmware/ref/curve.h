// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/ref/minimum_snap.h"

namespace m100::ref {

/// A horizontal curve of `turns` turns (also fractions), from rest to rest; phase p in rad, from 0 to 2 pi turns;
/// offsets x and y from its beginning in the world frame:
///   circle  x = a sin p, y = b (1 - cos p)   begins along +x; a = |radius|, b = radius: to the left, or, negative,
///                                            to the right
///   eight   x = a sin p, y = b sin 2 p       begins at its crossing
struct Curve {
  bool eight = false;
  double a_m = 0.0;
  double b_m = 0.0;
  double speed_m_s = 0.0;  ///< largest speed
  double turns = 0.0;

  static Curve circle(double radius_m, double speed_m_s, double turns);
  /// @param length_m from tip to tip along x. @param width_m along y.
  static Curve figure_of_eight(double length_m, double width_m, double speed_m_s, double turns);
};

/// Position on a curve as a function of time. In the first ramp_s the rate of the phase rises by the share 35 s^4 -
/// 84 s^5 + 70 s^6 - 20 s^7, s = t / ramp_s, and in the last ramp_s it falls in the same way: the first four time
/// derivatives of the position are continuous, also from and to rest.
class CurveTimes {
 public:
  /// @param acceleration_m_s2 largest acceleration along the path. On a curve that is too short to reach its speed with
  ///   it, the largest speed is lower.
  CurveTimes(const Curve& curve, double acceleration_m_s2);

  /// Number of pieces of degree 7 that keep the position to 1e-6 of the curve's size.
  std::size_t pieces() const { return 2 * ramp_pieces_ + cruise_pieces_; }
  /// Time from the beginning until `piece` pieces have ended, in whole microseconds; 0 for no piece.
  double end_s(std::size_t piece) const;
  /// Offset from the beginning and three time derivatives, at a time from 0 to end_s(pieces()).
  Node at(double time_s) const;

 private:
  Curve curve_;
  double rate_rad_s_ = 0.0;
  double ramp_s_ = 0.0;
  double cruise_s_ = 0.0;
  std::size_t ramp_pieces_ = 0;
  std::size_t cruise_pieces_ = 0;
};

/// Whether a and |b| are 5 cm to 500 m, the speed 1 cm/s to 100 m/s, and the turns more than 0.01 and at most 100.
bool usable(const Curve& curve);

}  // namespace m100::ref
