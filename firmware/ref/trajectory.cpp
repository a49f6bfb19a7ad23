// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/trajectory.h"

#include "firmware/core/maths.h"
#include "firmware/ref/minimum_snap.h"

namespace m100::ref {
namespace {

enum AxisIndex : std::size_t { kX, kY, kZ, kYaw };
constexpr double kQuinticSpeedPeak = 1.875;
constexpr double kQuinticAccelerationPeak = 5.7735026918962576;
constexpr double kShortestPiece_s = 0.2;
constexpr double kLongestPiece_s = 3600.0;
constexpr double kFarthest_m = 1000.0;

template <typename T>
bool usable(const Waypoint<T>& place) {
  const auto inside = [](T value, double limit) { return value <= T(limit) && value >= T(-limit); };
  return inside(place.position_w_m.x(), kFarthest_m) && inside(place.position_w_m.y(), kFarthest_m) &&
         inside(place.position_w_m.z(), kFarthest_m) && inside(place.yaw_rad, 100.0);
}

bool usable(const SpeedLimits& limits) {
  return limits.speed_m_s >= 0.01 && limits.acceleration_m_s2 >= 0.01 && limits.yaw_rate_rad_s >= 0.01 &&
         limits.speed_m_s <= 100.0 && limits.acceleration_m_s2 <= 100.0 && limits.yaw_rate_rad_s <= 100.0;
}

core::Duration duration_of(double duration_s) {
  return core::Duration(static_cast<core::Duration::rep>(duration_s * 1e6 + 0.999));
}

template <typename T>
Polynomial<T> narrowed(const Polynomial<double>& from) {
  Polynomial<T> to;
  for (std::size_t i = 0; i < kCoefficients; ++i) {
    to.c[i] = static_cast<T>(from.c[i]);
  }
  return to;
}

template <typename T>
std::array<double, 4> coordinates(const Waypoint<T>& place) {
  return {static_cast<double>(place.position_w_m.x()), static_cast<double>(place.position_w_m.y()),
          static_cast<double>(place.position_w_m.z()), static_cast<double>(place.yaw_rad)};
}

/// The yaw that turns the short way from another one.
double near(double yaw_rad, double from_rad) { return from_rad + core::wrap_pi(yaw_rad - from_rad); }

double distance(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  double sum = 0.0;
  for (const std::size_t i : {kX, kY, kZ}) {
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  }
  return core::sqrt(sum);
}

double larger(double a, double b) { return a > b ? a : b; }

Polynomial<double> piece_between(const Node& from, const Node& to, std::size_t d, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return through({.start = {from.position[d], from.velocity[d] * t, from.acceleration[d] * t2, from.jerk[d] * t3},
                  .end = {to.position[d], to.velocity[d] * t, to.acceleration[d] * t2, to.jerk[d] * t3}});
}

/// By how much all times must be multiplied so that the course just keeps its limits: speed goes with 1/k,
/// acceleration with 1/k^2, and the shape stays.
double time_factor(std::span<const Node> nodes, std::span<const double> durations_s, const SpeedLimits& limits) {
  constexpr int kSamples = 32;
  double factor = 0.0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    std::array<Polynomial<double>, 4> axis;
    for (std::size_t d = 0; d < kDimensions; ++d) {
      axis[d] = piece_between(nodes[i], nodes[i + 1], d, durations_s[i]);
    }
    for (int k = 0; k <= kSamples; ++k) {
      double speed2 = 0.0, acceleration2 = 0.0;
      const double s = static_cast<double>(k) / kSamples;
      for (const std::size_t d : {kX, kY, kZ}) {
        const AxisReference<double> r = axis[d].at(s, durations_s[i]);
        speed2 += r.velocity_m_s * r.velocity_m_s;
        acceleration2 += r.acceleration_m_s2 * r.acceleration_m_s2;
      }
      const double yaw_rate = axis[kYaw].at(s, durations_s[i]).velocity_m_s;
      factor = larger(factor, core::sqrt(speed2) / limits.speed_m_s);
      factor = larger(factor, core::sqrt(core::sqrt(acceleration2) / limits.acceleration_m_s2));
      factor = larger(factor, (yaw_rate < 0.0 ? -yaw_rate : yaw_rate) / limits.yaw_rate_rad_s);
    }
  }
  return factor;
}

}  // namespace

template <typename T>
void Trajectory<T>::hold(const Waypoint<T>& place) {
  count_ = 0;
  duration_ = core::Duration(0);
  start_ = place;
  end_ = place;
}

template <typename T>
core::Status Trajectory<T>::append(const Piece& piece, const Waypoint<T>& end) {
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
core::Status Trajectory<T>::append_step(const Waypoint<T>& place, core::Duration duration) {
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
core::Status Trajectory<T>::append_quintic(const Waypoint<T>& place, core::Duration duration) {
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
  double duration_s = larger(kQuinticSpeedPeak * way / limits.speed_m_s,
                             core::sqrt(kQuinticAccelerationPeak * way / limits.acceleration_m_s2));
  duration_s = larger(duration_s, kQuinticSpeedPeak * (turn < 0.0 ? -turn : turn) / limits.yaw_rate_rad_s);
  return append_quintic(place, duration_of(core::clamp(duration_s, kShortestPiece_s, kLongestPiece_s)));
}

template <typename T>
core::Status Trajectory<T>::append_minimum_snap(std::span<const Waypoint<T>> waypoints, const SpeedLimits& limits) {
  if (waypoints.empty() || !usable(limits)) {
    return core::Status::kInvalidArgument;
  }
  if (waypoints.size() > kMaxWaypoints || count_ + waypoints.size() > kMaxPieces) {
    return core::Status::kResourceExhausted;
  }
  std::array<Node, kMaxNodes> nodes{};
  std::array<double, kMaxNodes> durations_s{};
  nodes[0].position = coordinates(end_);
  const std::size_t pieces = waypoints.size();
  for (std::size_t i = 0; i < pieces; ++i) {
    if (!usable(waypoints[i])) {
      return core::Status::kOutOfRange;
    }
    nodes[i + 1].position = coordinates(waypoints[i]);
    nodes[i + 1].position[kYaw] = near(nodes[i + 1].position[kYaw], nodes[i].position[kYaw]);
    const double way = distance(nodes[i].position, nodes[i + 1].position);
    durations_s[i] =
        larger(kShortestPiece_s, larger(way / limits.speed_m_s, core::sqrt(way / limits.acceleration_m_s2)));
  }
  const std::span<Node> course(nodes.data(), pieces + 1);
  const std::span<double> times(durations_s.data(), pieces);
  minimise_snap(course, times);
  const double factor = time_factor(course, times, limits);
  for (double& time_s : times) {
    time_s = core::clamp(time_s * factor, kShortestPiece_s * 0.25, kLongestPiece_s);
    time_s = core::seconds<double>(duration_of(time_s));
  }
  minimise_snap(course, times);
  for (std::size_t i = 0; i < pieces; ++i) {
    Piece piece{.kind = Kind::kPolynomial, .duration = duration_of(times[i] - 0.5e-6)};
    for (std::size_t d = 0; d < kDimensions; ++d) {
      piece.axis[d] = narrowed<T>(piece_between(course[i], course[i + 1], d, times[i]));
    }
    Waypoint<T> end = waypoints[i];
    end.yaw_rad = static_cast<T>(course[i + 1].position[kYaw]);
    const core::Status status = append(piece, end);
    if (status != core::Status::kOk) {
      return status;
    }
  }
  return core::Status::kOk;
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
void Trajectory<T>::stand(Window<T>& window, const Waypoint<T>& place) const {
  window.x.fill({.position_m = place.position_w_m.x()});
  window.y.fill({.position_m = place.position_w_m.y()});
  window.height = {.position_m = place.position_w_m.z()};
  window.yaw_rad = core::wrap_pi(place.yaw_rad);
  window.yaw_rate_rad_s = T(0);
  window.constant = true;
}

template <typename T>
void Trajectory<T>::fill(Window<T>& window, core::TimePoint now, core::Duration lead) const {
  const core::Duration time = now - begin_;
  if (count_ == 0) {
    stand(window, start_);
    return;
  }
  std::size_t piece = 0;  // that of now: set points count from their beginning on
  while (piece + 1 < count_ && time >= pieces_[piece + 1].begin) {
    ++piece;
  }
  const Moment present = moment(pieces_[piece], time);
  window.height = sample(present, kZ);
  const AxisReference<T> yaw = sample(present, kYaw);
  window.yaw_rad = core::wrap_pi(yaw.position_m);
  window.yaw_rate_rad_s = yaw.velocity_m_s;

  const std::size_t first = piece;
  core::Duration at = time + lead;
  for (std::size_t k = 0; k <= kHorizon; ++k) {
    piece = piece_at(piece, at);
    const Moment then = moment(pieces_[piece], at);
    window.x[k] = sample(then, kX);
    window.y[k] = sample(then, kY);
    at += std::chrono::milliseconds(100);
  }
  const bool over = piece == first && time >= pieces_[piece].begin + pieces_[piece].duration;
  window.constant = piece == first && (pieces_[piece].kind == Kind::kSetpoint || over);
}

template class Trajectory<float>;
template class Trajectory<double>;

}  // namespace m100::ref
