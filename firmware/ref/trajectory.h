// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/core/eigen.h"
#include "firmware/core/expected.h"
#include "firmware/core/time.h"
#include "firmware/ref/polynomial.h"
#include "firmware/ref/window.h"

namespace m100::ref {

/// A place and a heading, world frame.
template <typename T>
struct Waypoint {
  core::Vector<T, 3> position_w_m = core::Vector<T, 3>::Zero();
  T yaw_rad{0};
};

struct SpeedLimits {
  double speed_m_s = 1.5;
  double acceleration_m_s2 = 2.0;
  double yaw_rate_rad_s = 0.8;
};

/// Pieces of a flight, one after the other, from the time it was started; before the first and after the last it stays
/// at their ends. Fixed capacity, no allocation; building may take milliseconds, window() is bounded: 42 polynomials.
///
/// A set point (hold, step) fills the whole window at once, as if nobody knew what comes next (the paper's steps are
/// chosen by hand), and sets Window::constant. Everything else is previewed.
template <typename T>
class Trajectory {
 public:
#ifdef M100_SMALL_MEMORY
  static constexpr std::size_t kMaxPieces = 16;
#else
  static constexpr std::size_t kMaxPieces = 64;
#endif
  static constexpr std::size_t kMaxWaypoints = 32;  ///< of one minimum-snap course

  /// Begins anew, standing at a place for ever.
  void hold(const Waypoint<T>& place);
  /// Appends: jumps to a place and stands there. kResourceExhausted, kOutOfRange (not finite, or no time).
  core::Status append_step(const Waypoint<T>& place, core::Duration duration);
  /// Appends: rest to rest in a straight line, degree 5, in a given time, or as fast as the limits allow.
  core::Status append_quintic(const Waypoint<T>& place, core::Duration duration);
  core::Status append_quintic(const Waypoint<T>& place, const SpeedLimits& limits);
  /// Appends: from the end of what is there, at rest, through the waypoints to rest at the last, with the least snap
  /// (integral of the squared fourth derivative) for time shares by distance; then all times are stretched or shrunk
  /// together until speed, acceleration and yaw rate just keep their limits.
  core::Status append_minimum_snap(std::span<const Waypoint<T>> waypoints, const SpeedLimits& limits);
  /// Appends: once around a horizontal square (paper, IV-C.4: 1 x 1 m), corner at the end of what is there, along +x
  /// first, at rest in every corner for `pause`.
  core::Status append_square(T side_m, core::Duration per_side, core::Duration pause);
  /// Time zero of the first piece.
  void start(core::TimePoint begin) { begin_ = begin; }
  core::Duration duration() const { return duration_; }
  bool finished(core::TimePoint now) const { return now - begin_ >= duration_; }

  /// The reference at `now` (height, yaw) and from now + lead on (x, y).
  Window<T> window(core::TimePoint now, core::Duration lead) const {
    Window<T> window;
    fill(window, now, lead);
    return window;
  }
  /// The same without a copy.
  void fill(Window<T>& window, core::TimePoint now, core::Duration lead) const;

 private:
  enum class Kind : unsigned char { kSetpoint, kPolynomial };
  struct Piece {
    Kind kind = Kind::kSetpoint;
    std::array<unsigned char, 4> coefficients{1, 1, 1, 1};  ///< of each axis, up to the last that is not zero
    core::Duration begin{0};
    core::Duration duration{0};
    std::array<Polynomial<T>, 4> axis{};  ///< x, y, z, yaw; a set point has constants only
  };
  core::Status append(const Piece& piece, const Waypoint<T>& end);
  /// A moment of a piece in its own time.
  struct Moment {
    const Piece* piece;
    T s{0};           ///< share of the duration, 0..1
    T duration_s{1};  ///< 0: at rest, before the piece or behind it
  };
  static Moment moment(const Piece& piece, core::Duration time);
  static AxisReference<T> sample(const Moment& moment, std::size_t axis);
  void stand(Window<T>& window, const Waypoint<T>& place) const;
  /// The piece of a time, looking on from piece `from`, not across the beginning of a set point that is yet to come.
  std::size_t piece_at(std::size_t from, core::Duration time) const;

  std::array<Piece, kMaxPieces> pieces_{};
  std::size_t count_ = 0;
  Waypoint<T> start_{};
  Waypoint<T> end_{};
  core::Duration duration_{0};
  core::TimePoint begin_{};
};

extern template class Trajectory<float>;
extern template class Trajectory<double>;

}  // namespace m100::ref
