// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/core/expected.h"
#include "firmware/ref/minimum_snap.h"

namespace m100::ref {

/// A horizontal curve that is flown again and again, from rest to rest; phase p in rad, from 0 to 2 pi turns, offsets
/// from its beginning in the world frame:
///   circle  x = a sin p, y = b (1 - cos p)   begins along +x; a = |radius|, b = radius: to the left, or, negative,
///                                            to the right
///   eight   x = a sin p, y = b sin 2 p       begins where it crosses itself
struct Curve {
  bool eight = false;
  double a_m = 0.0;
  double b_m = 0.0;
  double speed_m_s = 0.0;  ///< the highest
  double turns = 0.0;

  static Curve circle(double radius_m, double speed_m_s, double turns);
  /// @param length_m from tip to tip along x. @param width_m along y.
  static Curve figure_of_eight(double length_m, double width_m, double speed_m_s, double turns);
};

/// When a curve is where. The phase gains its rate over `ramp_s` by 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7 and loses it in
/// the same way: the first four derivatives by time of the place are continuous, at the ends too.
class CurveTimes {
 public:
  /// @param acceleration_m_s2 that the ramp may take along the path. A curve that is too short for its speed is flown
  ///   more slowly.
  CurveTimes(const Curve& curve, double acceleration_m_s2);

  /// How many pieces of degree 7 keep the place to 1e-6 of its size.
  std::size_t pieces() const { return 2 * ramp_pieces_ + cruise_pieces_; }
  /// The end of a piece, in whole microseconds from the beginning; that of none is 0.
  double end_s(std::size_t piece) const;
  /// Offset from the beginning and its derivatives by time, of a time from 0 to end_s(pieces()).
  Node at(double time_s) const;

 private:
  Curve curve_;
  double rate_rad_s_ = 0.0;
  double ramp_s_ = 0.0;
  double cruise_s_ = 0.0;
  std::size_t ramp_pieces_ = 0;
  std::size_t cruise_pieces_ = 0;
};

/// Sizes from 5 cm to 500 m, speed 1 cm/s to 100 m/s, up to 100 turns.
bool usable(const Curve& curve);

}  // namespace m100::ref
