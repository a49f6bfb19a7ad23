// SPDX-License-Identifier: BSD-3-Clause
// Appends courses through waypoints, curves and polynomials to a Trajectory.
#include "firmware/model/vehicle.h"
#include "firmware/ref/trajectory_detail.h"

namespace m100::ref {
namespace {

Polynomial<double> piece_between(const Node& from, const Node& to, std::size_t d, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return through({.start = {from.position[d], from.velocity[d] * t, from.acceleration[d] * t2, from.jerk[d] * t3},
                  .end = {to.position[d], to.velocity[d] * t, to.acceleration[d] * t2, to.jerk[d] * t3}});
}

/// Factor k by which all times must be multiplied so that this point just keeps the limits: speed is proportional to
/// 1/k, acceleration to 1/k^2, and the shape stays. The tilt keeps its limit where
/// horizontal / k^2 <= tan(tilt) (g + vertical / k^2).
double factor_of(const std::array<AxisReference<double>, kDimensions>& at, const SpeedLimits& limits) {
  double speed2 = 0.0, acceleration2 = 0.0;
  for (const std::size_t d : {kX, kY, kZ}) {
    speed2 += at[d].velocity_m_s * at[d].velocity_m_s;
    acceleration2 += at[d].acceleration_m_s2 * at[d].acceleration_m_s2;
  }
  const double up_m_s2 = at[kZ].acceleration_m_s2;
  const double aside_m_s2 = core::sqrt(acceleration2 - up_m_s2 * up_m_s2);
  const double yaw_rate = at[kYaw].velocity_m_s;
  double factor = core::sqrt(speed2) / limits.speed_m_s;
  factor = larger(factor, core::sqrt(core::sqrt(acceleration2) / limits.acceleration_m_s2));
  factor = larger(factor, core::sqrt((aside_m_s2 / core::tan(limits.tilt_rad) - up_m_s2) / model::kGravity_m_s2));
  return larger(factor, (yaw_rate < 0.0 ? -yaw_rate : yaw_rate) / limits.yaw_rate_rad_s);
}

/// The factor by which all times of a course must be multiplied to just keep the limits, by 33 points of each piece.
double time_factor(std::span<const Node> nodes, std::span<const double> durations_s, const SpeedLimits& limits) {
  constexpr int kSamples = 32;
  double factor = 0.0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    std::array<Polynomial<double>, kDimensions> axis;
    for (std::size_t d = 0; d < kDimensions; ++d) {
      axis[d] = piece_between(nodes[i], nodes[i + 1], d, durations_s[i]);
    }
    for (int k = 0; k <= kSamples; ++k) {
      std::array<AxisReference<double>, kDimensions> at;
      for (std::size_t d = 0; d < kDimensions; ++d) {
        at[d] = axis[d].at(static_cast<double>(k) / kSamples, durations_s[i]);
      }
      factor = larger(factor, factor_of(at, limits));
    }
  }
  return factor;
}

}  // namespace

double tilt_of(double x_m_s2, double y_m_s2, double z_m_s2) {
  return core::atan2(core::sqrt(x_m_s2 * x_m_s2 + y_m_s2 * y_m_s2), model::kGravity_m_s2 + z_m_s2);
}

template <typename T>
core::Status Trajectory<T>::append_between(const Node& from, const Node& to, core::Duration duration) {
  Piece piece{.kind = Kind::kPolynomial, .duration = duration};
  for (std::size_t d = 0; d < kDimensions; ++d) {
    piece.axis[d] = narrowed<T>(piece_between(from, to, d, core::seconds<double>(duration)));
  }
  return append(piece, waypoint<T>(to.position));
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
    durations_s[i] = larger(kMinPiece_s, larger(way / limits.speed_m_s, core::sqrt(way / limits.acceleration_m_s2)));
  }
  const std::span<Node> course(nodes.data(), pieces + 1);
  const std::span<double> times(durations_s.data(), pieces);
  minimise_snap(course, times);
  const double factor = time_factor(course, times, limits);
  for (double& time_s : times) {
    time_s = core::clamp(time_s * factor, kMinPiece_s * 0.25, kMaxPiece_s);
    time_s = core::seconds<double>(duration_of(time_s));
  }
  minimise_snap(course, times);
  core::Status status = core::Status::kOk;
  for (std::size_t i = 0; i < pieces && status == core::Status::kOk; ++i) {
    status = append_between(course[i], course[i + 1], duration_of(times[i] - 0.5e-6));
  }
  return status;
}

template <typename T>
core::Status Trajectory<T>::append_timed(std::span<const TimedWaypoint<T>> waypoints) {
  if (waypoints.empty()) {
    return core::Status::kInvalidArgument;
  }
  if (waypoints.size() > kMaxWaypoints || count_ + waypoints.size() > kMaxPieces) {
    return core::Status::kResourceExhausted;
  }
  std::array<Node, kMaxNodes> nodes{};
  std::array<double, kMaxNodes> durations_s{};
  nodes[0].position = coordinates(end_);
  core::Duration before{0};
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (!usable(waypoints[i].place)) {
      return core::Status::kOutOfRange;
    }
    if (waypoints[i].at - before < kMinWaypointSpacing || waypoints[i].at - before > std::chrono::hours(1)) {
      return core::Status::kInvalidArgument;
    }
    nodes[i + 1].position = coordinates(waypoints[i].place);
    nodes[i + 1].position[kYaw] = near(nodes[i + 1].position[kYaw], nodes[i].position[kYaw]);
    durations_s[i] = core::seconds<double>(waypoints[i].at - before);
    before = waypoints[i].at;
  }
  minimise_snap(std::span(nodes.data(), waypoints.size() + 1), std::span(durations_s.data(), waypoints.size()));
  before = core::Duration(0);
  core::Status status = core::Status::kOk;
  for (std::size_t i = 0; i < waypoints.size() && status == core::Status::kOk; ++i) {
    status = append_between(nodes[i], nodes[i + 1], waypoints[i].at - before);
    before = waypoints[i].at;
  }
  return status;
}

template <typename T>
core::Status Trajectory<T>::append_curve(const Curve& curve, const SpeedLimits& limits) {
  if (!usable(curve) || !usable(limits)) {
    return core::Status::kOutOfRange;
  }
  const double by_tilt_m_s2 = model::kGravity_m_s2 * core::tan(limits.tilt_rad);
  const double most_m_s2 = by_tilt_m_s2 < limits.acceleration_m_s2 ? by_tilt_m_s2 : limits.acceleration_m_s2;
  const CurveTimes times(curve, 0.5 * most_m_s2);
  if (count_ + times.pieces() > kMaxPieces) {
    return core::Status::kResourceExhausted;
  }
  const std::array<double, kDimensions> origin = coordinates(end_);
  const auto node_at = [&](double time_s) {
    Node node = times.at(time_s);
    for (std::size_t d = 0; d < kDimensions; ++d) {
      node.position[d] += origin[d];
    }
    return node;
  };
  Node from = node_at(0.0);
  core::Status status = core::Status::kOk;
  for (std::size_t i = 1; i <= times.pieces() && status == core::Status::kOk; ++i) {
    const Node to = node_at(times.end_s(i));
    status = append_between(from, to, duration_of(times.end_s(i) - times.end_s(i - 1) - 0.5e-6));
    from = to;
  }
  return status;
}

template <typename T>
core::Status Trajectory<T>::append_polynomial(const std::array<Polynomial<double>, kDimensions>& axes,
                                              core::Duration duration) {
  if (duration <= core::Duration(0)) {
    return core::Status::kOutOfRange;
  }
  Piece piece{.kind = Kind::kPolynomial, .duration = duration};
  std::array<double, kDimensions> end{};
  for (std::size_t d = 0; d < kDimensions; ++d) {
    piece.axis[d] = narrowed<T>(axes[d]);
    end[d] = axes[d].derivative(0, 1.0, 1.0);
  }
  const Waypoint<T> place = waypoint<T>(end);
  return usable(place) ? append(piece, place) : core::Status::kOutOfRange;
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define M100_TRAJECTORY_APPEND(T)                                                                             \
  template core::Status Trajectory<T>::append_between(const Node&, const Node&, core::Duration);              \
  template core::Status Trajectory<T>::append_minimum_snap(std::span<const Waypoint<T>>, const SpeedLimits&); \
  template core::Status Trajectory<T>::append_timed(std::span<const TimedWaypoint<T>>);                       \
  template core::Status Trajectory<T>::append_curve(const Curve&, const SpeedLimits&);                        \
  template core::Status Trajectory<T>::append_polynomial(const std::array<Polynomial<double>, kDimensions>&,  \
                                                         core::Duration)
// NOLINTEND(bugprone-macro-parentheses)
M100_TRAJECTORY_APPEND(float);
M100_TRAJECTORY_APPEND(double);
#undef M100_TRAJECTORY_APPEND

}  // namespace m100::ref
