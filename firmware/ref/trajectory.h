// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <span>

#include "firmware/core/eigen.h"
#include "firmware/core/expected.h"
#include "firmware/core/time.h"
#include "firmware/ref/curve.h"
#include "firmware/ref/minimum_snap.h"
#include "firmware/ref/polynomial.h"
#include "firmware/ref/window.h"

namespace m100::ref {

/// A position and a heading, world frame.
template <typename T>
struct Waypoint {
  core::Vector<T, 3> position_w_m = core::Vector<T, 3>::Zero();
  T yaw_rad{0};
};

/// A waypoint with the time at which it is passed, counted from the beginning of the way that append_timed() appends.
template <typename T>
struct TimedWaypoint {
  Waypoint<T> place;
  core::Duration at{0};
};

struct SpeedLimits {
  double speed_m_s = 1.5;
  double acceleration_m_s2 = 2.0;
  double yaw_rate_rad_s = 0.8;
  double tilt_rad = 0.4363323129985824;  ///< 25 deg; tilt of the thrust that the acceleration needs, tilt_of()
};

/// The tilt needed for an acceleration (world, m/s^2) in still air without drag: atan(horizontal / (g + vertical)).
double tilt_of(double x_m_s2, double y_m_s2, double z_m_s2);

/// x, y, z [m] and yaw [rad], each with its first four time derivatives.
using Motion = std::array<std::array<double, 5>, kDimensions>;

/// The pieces of a flight, one after the other, relative to its start. Before the first and after the last piece the
/// reference stays at their ends. Fixed capacity, no allocation. Building may take milliseconds and belongs before the
/// flight; the cost of window() is bounded.
///
/// A set point (hold, step) enters the window only when it begins, without preview. Other pieces are previewed.
/// Window::constant is set while one set point, or the end of the last piece, fills the whole window.
template <typename T>
class Trajectory {
 public:
#ifdef M100_SMALL_MEMORY
  static constexpr std::size_t kMaxPieces = 16;
#else
  static constexpr std::size_t kMaxPieces = 1024;
#endif
  static constexpr std::size_t kMaxWaypoints = kMaxNodes - 1;  ///< of one minimum-snap course

  /// Clears the trajectory and holds a position without end.
  void hold(const Waypoint<T>& place);
  /// Appends a jump to a position, held for `duration`. kResourceExhausted, kOutOfRange (beyond 1 km, or no duration).
  core::Status append_step(const Waypoint<T>& place, core::Duration duration);
  /// Appends a straight line from rest to rest, degree 5, in a given time or as fast as `limits` (except tilt) allow.
  core::Status append_quintic(const Waypoint<T>& place, core::Duration duration);
  core::Status append_quintic(const Waypoint<T>& place, const SpeedLimits& limits);
  /// Appends a way from rest at the present end through the waypoints to rest at the last, with the least snap
  /// (integral of the squared fourth derivative). The times are such that speed, acceleration, tilt and yaw rate just
  /// keep their limits (within 1 %).
  core::Status append_minimum_snap(std::span<const Waypoint<T>> waypoints, const SpeedLimits& limits);
  /// Appends a way from rest at the present end through the waypoints at their times, kMinWaypointSpacing to one hour
  /// apart (otherwise kInvalidArgument), to rest at the last, with the least snap. Limits are not checked.
  core::Status append_timed(std::span<const TimedWaypoint<T>> waypoints);
  /// Appends a curve from the present end, at rest at both ends. Half of what the limits of acceleration and tilt allow
  /// is used for speeding up and slowing down; whether the rest is enough for the bends is not checked.
  core::Status append_curve(const Curve& curve, const SpeedLimits& limits);
  /// Appends polynomials of x, y, z, yaw in normalised time, world frame. That they begin at end() is not checked.
  core::Status append_polynomial(const std::array<Polynomial<double>, kDimensions>& axes, core::Duration duration);
  /// Appends one round of a horizontal square (paper, IV-C.4: 1 x 1 m) from the present end as a corner, along +x
  /// first, at rest in every corner for `pause`.
  core::Status append_square(T side_m, core::Duration per_side, core::Duration pause);
  /// Time zero of the first piece.
  void start(core::TimePoint begin) { begin_ = begin; }
  /// Call it in ticks without a fresh pose. If a piece that begins at rest would have begun in the last `elapsed`, it
  /// begins just after now instead, and all later pieces are delayed by as much. A piece that continues a motion is not
  /// delayed.
  void postpone(core::TimePoint now, core::Duration elapsed);
  core::Duration duration() const { return duration_; }
  const Waypoint<T>& end() const { return end_; }  ///< where the last piece ends
  std::size_t pieces() const { return count_; }
  core::Duration piece_end(std::size_t piece) const { return pieces_[piece].begin + pieces_[piece].duration; }
  /// The motion at a time since the start, for checks and pictures, not for the tick.
  /// @param arriving at the boundary of two pieces, use the piece that ends there, not the one that begins
  Motion motion(core::Duration since_start, bool arriving = false) const;
  bool finished(core::TimePoint now) const { return now - begin_ >= duration_; }

  /// The reference at `now` (height, yaw) and over the horizon from now + lead (x, y); lead >= 0.
  Window<T> window(core::TimePoint now, core::Duration lead) const {
    Window<T> window;
    fill(window, now, lead);
    return window;
  }
  /// window() without a copy.
  /// @param points how many of x and y to fill, 1 to kHorizon + 1; the others are not used and may keep old values
  void fill(Window<T>& window, core::TimePoint now, core::Duration lead, std::size_t points = kHorizon + 1) const;

 private:
  enum class Kind : unsigned char { kSetpoint, kPolynomial };
  struct Piece {
    Kind kind = Kind::kSetpoint;
    std::array<unsigned char, 4> coefficients{1, 1, 1, 1};  ///< number for each axis, up to the last nonzero one
    core::Duration begin{0};
    core::Duration duration{0};
    std::array<Polynomial<T>, 4> axis{};  ///< x, y, z, yaw; a set point has constants only
  };
  core::Status append(const Piece& piece, const Waypoint<T>& end);
  core::Status append_between(const Node& from, const Node& to, core::Duration duration);
  /// A time within a piece.
  struct Moment {
    const Piece* piece;
    T s{0};           ///< share of the duration, 0..1
    T duration_s{1};  ///< 0: at rest, in a set point or before or after the piece
  };
  static Moment moment(const Piece& piece, core::Duration time);
  static AxisReference<T> sample(const Moment& moment, std::size_t axis);
  void fill_constant(Window<T>& window, const Waypoint<T>& place) const;
  /// The piece at a time: the last that has begun by then, or the first if none has. There must be one.
  std::size_t begun_by(core::Duration time) const;
  static bool begins_at_rest(const Piece& piece);
  /// The piece at a time, searched forward from piece `from`, but not past the beginning of a future set point.
  std::size_t piece_at(std::size_t from, core::Duration time) const;

  std::array<Piece, kMaxPieces> pieces_{};
  std::size_t count_ = 0;
  Waypoint<T> start_{};
  Waypoint<T> end_{};
  core::Duration duration_{0};
  core::TimePoint begin_{};
};

/// Least time between two waypoints of append_timed().
inline constexpr core::Duration kMinWaypointSpacing = std::chrono::milliseconds(50);

extern template class Trajectory<float>;
extern template class Trajectory<double>;

}  // namespace m100::ref
