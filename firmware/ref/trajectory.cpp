// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/trajectory.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"
#include "firmware/ref/trajectory_detail.h"

namespace m100::ref {
namespace {

constexpr core::Duration kStep = std::chrono::milliseconds(100);  ///< kPredictionStep_s
constexpr double kQuinticSpeedPeak = 1.875;
constexpr double kQuinticAccelerationPeak = 5.7735026918962576;

}  // namespace

template <typename T>
[[gnu::cold]] void Trajectory<T>::hold(const Waypoint<T>& place) {
  count_ = 0;
  duration_ = core::Duration(0);
  start_ = place;
  end_ = place;
}

template <typename T>
[[gnu::cold]] core::Status Trajectory<T>::append(const Piece& piece, const Waypoint<T>& end) {
  if (count_ == kMaxPieces) {
    return core::Status::kResourceExhausted;
  }
  pieces_[count_] = piece;
  pieces_[count_].begin = duration_;
  for (std::size_t axis = 0; axis < piece.axis.size(); ++axis) {
    pieces_[count_].coefficients[axis] = static_cast<unsigned char>(piece.axis[axis].count());
  }
  duration_ += piece.duration;
  end_ = end;
  ++count_;
  return core::Status::kOk;
}

template <typename T>
[[gnu::cold]] core::Status Trajectory<T>::append_step(const Waypoint<T>& place, core::Duration duration) {
  if (!usable(place) || duration <= core::Duration(0)) {
    return core::Status::kOutOfRange;
  }
  Piece piece{.kind = Kind::kSetpoint, .duration = duration};
  const std::array<double, 4> at = coordinates(place);
  for (std::size_t d = 0; d < 4; ++d) {
    piece.axis[d].c[0] = static_cast<T>(at[d]);
  }
  return append(piece, place);
}

template <typename T>
[[gnu::cold]] core::Status Trajectory<T>::append_quintic(const Waypoint<T>& place, core::Duration duration) {
  if (!usable(place) || duration <= core::Duration(0)) {
    return core::Status::kOutOfRange;
  }
  Piece piece{.kind = Kind::kPolynomial, .duration = duration};
  const std::array<double, 4> from = coordinates(end_);
  std::array<double, 4> to = coordinates(place);
  to[kYaw] = near(to[kYaw], from[kYaw]);
  for (std::size_t d = 0; d < 4; ++d) {
    piece.axis[d] = narrowed<T>(quintic(from[d], to[d]));
  }
  Waypoint<T> end = place;
  end.yaw_rad = static_cast<T>(to[kYaw]);
  return append(piece, end);
}

template <typename T>
core::Status Trajectory<T>::append_quintic(const Waypoint<T>& place, const SpeedLimits& limits) {
  if (!usable(place) || !usable(limits)) {
    return core::Status::kOutOfRange;
  }
  const double way = distance(coordinates(end_), coordinates(place));
  const double turn = core::wrap_pi(static_cast<double>(place.yaw_rad) - static_cast<double>(end_.yaw_rad));
  double duration_s = core::max(kQuinticSpeedPeak * way / limits.speed_m_s,
                                core::sqrt(kQuinticAccelerationPeak * way / limits.acceleration_m_s2));
  duration_s = core::max(duration_s, kQuinticSpeedPeak * core::abs(turn) / limits.yaw_rate_rad_s);
  return append_quintic(place, duration_of(core::clamp(duration_s, kMinPiece_s, kMaxPiece_s)));
}

template <typename T>
core::Status Trajectory<T>::append_square(T side_m, core::Duration per_side, core::Duration pause) {
  constexpr std::array<std::array<int, 2>, 4> kWay{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  for (const auto& way : kWay) {
    Waypoint<T> corner = end_;
    corner.position_w_m.x() += static_cast<T>(way[0]) * side_m;
    corner.position_w_m.y() += static_cast<T>(way[1]) * side_m;
    core::Status status = append_quintic(corner, per_side);
    if (status == core::Status::kOk && pause > core::Duration(0)) {
      status = append_quintic(corner, pause);
    }
    if (status != core::Status::kOk) {
      return status;
    }
  }
  return core::Status::kOk;
}

template <typename T>
std::size_t Trajectory<T>::begun_by(core::Duration time) const {
  std::size_t low = 0, high = count_ - 1;
  while (low < high) {
    const std::size_t middle = (low + high + 1) / 2;
    if (time >= pieces_[middle].begin) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

template <typename T>
std::size_t Trajectory<T>::piece_at(std::size_t from, core::Duration time) const {
  std::size_t piece = from;
  while (piece + 1 < count_ && time >= pieces_[piece + 1].begin && pieces_[piece + 1].kind != Kind::kSetpoint) {
    ++piece;
  }
  return piece;
}

template <typename T>
typename Trajectory<T>::Moment Trajectory<T>::moment(const Piece& piece, core::Duration time) {
  const core::Duration since = time - piece.begin;
  if (piece.kind == Kind::kSetpoint || since < core::Duration(0)) {
    return {.piece = &piece, .s = T(0), .duration_s = T(0)};
  }
  if (since >= piece.duration) {
    return {.piece = &piece, .s = T(1), .duration_s = T(0)};
  }
  const T duration_s = core::seconds<T>(piece.duration);
  return {.piece = &piece, .s = core::seconds<T>(since) / duration_s, .duration_s = duration_s};
}

template <typename T>
AxisReference<T> Trajectory<T>::sample(const Moment& moment, std::size_t axis) {
  M100_ASSERT(axis < moment.piece->axis.size());
  const Polynomial<T>& polynomial = moment.piece->axis[axis];
  const std::size_t count = moment.piece->coefficients[axis];
  if (count == 1) {
    return {.position_m = polynomial.c[0]};
  }
  if (moment.duration_s == T(0)) {
    return {.position_m = polynomial.at(moment.s, T(1), count).position_m};
  }
  return polynomial.at(moment.s, moment.duration_s, count);
}

template <typename T>
void Trajectory<T>::fill_constant(Window<T>& window, const Waypoint<T>& place) const {
  window.x.fill({.position_m = place.position_w_m.x()});
  window.y.fill({.position_m = place.position_w_m.y()});
  window.height = {.position_m = place.position_w_m.z()};
  window.yaw_rad = core::wrap_pi(place.yaw_rad);
  window.yaw_rate_rad_s = T(0);
  window.constant = true;
}

template <typename T>
void Trajectory<T>::fill(Window<T>& window, core::TimePoint now, core::Duration lead, std::size_t points) const {
  M100_ASSERT(lead >= core::Duration(0) && points >= 1 && points <= kHorizon + 1);
  const core::Duration time = now - begin_;
  if (count_ == 0) {
    fill_constant(window, start_);
    return;
  }
  std::size_t piece = begun_by(time);  // a set point applies from its beginning, without preview
  const Moment present = moment(pieces_[piece], time);
  window.height = sample(present, kZ);
  const AxisReference<T> yaw = sample(present, kYaw);
  window.yaw_rad = core::wrap_pi(yaw.position_m);
  window.yaw_rate_rad_s = yaw.velocity_m_s;

  const std::size_t first = piece;
  core::Duration at = time + lead;
  for (std::size_t k = 0; k < points; ++k) {
    piece = piece_at(piece, at);
    const Moment then = moment(pieces_[piece], at);
    window.x[k] = sample(then, kX);
    window.y[k] = sample(then, kY);
    at += kStep;
  }
  piece = piece_at(piece, time + lead + kHorizon * kStep);
  const bool over = piece == first && time >= pieces_[piece].begin + pieces_[piece].duration;
  window.constant = piece == first && (pieces_[piece].kind == Kind::kSetpoint || over);
}

template <typename T>
Motion Trajectory<T>::motion(core::Duration since_start, bool arriving) const {
  Motion out{};
  if (count_ == 0) {
    const std::array<double, 4> at = coordinates(start_);
    for (std::size_t d = 0; d < kDimensions; ++d) {
      out[d][0] = at[d];
    }
    return out;
  }
  std::size_t index = begun_by(since_start);
  if (arriving && index > 0 && since_start == pieces_[index].begin) {
    --index;
  }
  const Piece& piece = pieces_[index];
  const core::Duration in_piece = since_start - piece.begin;
  const bool over = arriving ? in_piece > piece.duration : in_piece >= piece.duration;
  const double duration_s = core::seconds<double>(piece.duration);
  const double s = over ? 1.0 : core::clamp(core::seconds<double>(in_piece) / duration_s, 0.0, 1.0);
  const bool stands = over || piece.kind == Kind::kSetpoint || in_piece < core::Duration(0);
  for (std::size_t d = 0; d < kDimensions; ++d) {
    for (unsigned order = 0; order < (stands ? 1U : 5U); ++order) {
      out[d][order] = piece.axis[d].derivative(order, s, duration_s);
    }
  }
  return out;
}

template class Trajectory<float>;
template class Trajectory<double>;

}  // namespace m100::ref
