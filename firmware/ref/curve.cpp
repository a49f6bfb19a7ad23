// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/curve.h"

#include <cstdint>

#include "firmware/core/maths.h"

namespace m100::ref {
namespace {

constexpr std::size_t kRampPieces = 8;
constexpr double kRampSteepest = 2.1875;  // largest slope of the ramp polynomial in s, at its middle: 140 / 64
constexpr double kShortestCruise_s = 0.05;

/// Rounds a time so that it divides into `pieces` pieces of whole microseconds.
double in_pieces(double time_s, std::size_t pieces) {
  const double count = static_cast<double>(pieces);
  return static_cast<double>(static_cast<std::int64_t>(time_s * 1e6 / count + 0.5)) * count / 1e6;
}

std::size_t at_least(std::size_t least, double wanted) {
  const auto count = static_cast<std::size_t>(wanted) + 1;
  return count > least ? count : least;
}

double size(double value) { return value < 0.0 ? -value : value; }

/// Phase and its first three time derivatives.
struct Phase {
  double p = 0.0, p1 = 0.0, p2 = 0.0, p3 = 0.0;
};

/// The phase and its rates in the ramp at s = t / ramp_s: the integral, the ramp polynomial and two derivatives.
Phase ramped(double s, double rate_rad_s, double ramp_s) {
  const double s2 = s * s, s3 = s2 * s, left = 1.0 - s;
  const double value = s2 * s2 * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)));
  const double integral = s3 * s2 * (7.0 + s * (-14.0 + s * (10.0 - 2.5 * s)));
  const double slope = 140.0 * s3 * left * left * left;
  const double bend = 420.0 * s2 * left * left * (1.0 - 2.0 * s);
  return {.p = rate_rad_s * ramp_s * integral,
          .p1 = rate_rad_s * value,
          .p2 = rate_rad_s * slope / ramp_s,
          .p3 = rate_rad_s * bend / (ramp_s * ramp_s)};
}

/// Sine or cosine of n times the phase and its time derivatives: f = g(p(t)) by the chain rule, g''' = -n^2 g'.
struct Swing {
  double value = 0.0, first = 0.0, second = 0.0, third = 0.0;
};
Swing chain(double g, double g1, double n, const Phase& phase) {
  const double g2 = -n * n * g, g3 = -n * n * g1;
  return {.value = g,
          .first = g1 * phase.p1,
          .second = g2 * phase.p1 * phase.p1 + g1 * phase.p2,
          .third = g3 * phase.p1 * phase.p1 * phase.p1 + 3.0 * g2 * phase.p1 * phase.p2 + g1 * phase.p3};
}

void add(Node& node, std::size_t axis, double factor, const Swing& swing) {
  node.position[axis] += factor * swing.value;
  node.velocity[axis] += factor * swing.first;
  node.acceleration[axis] += factor * swing.second;
  node.jerk[axis] += factor * swing.third;
}

}  // namespace

Curve Curve::circle(double radius_m, double speed_m_s, double turns) {
  return {.eight = false, .a_m = size(radius_m), .b_m = radius_m, .speed_m_s = speed_m_s, .turns = turns};
}

Curve Curve::figure_of_eight(double length_m, double width_m, double speed_m_s, double turns) {
  return {.eight = true, .a_m = 0.5 * length_m, .b_m = 0.5 * width_m, .speed_m_s = speed_m_s, .turns = turns};
}

bool usable(const Curve& curve) {
  return curve.a_m >= 0.05 && size(curve.b_m) >= 0.05 && curve.a_m <= 500.0 && size(curve.b_m) <= 500.0 &&
         curve.speed_m_s >= 0.01 && curve.speed_m_s <= 100.0 && curve.turns > 0.01 && curve.turns <= 100.0;
}

CurveTimes::CurveTimes(const Curve& curve, double acceleration_m_s2) : curve_(curve) {
  const double total_rad = 2.0 * core::kPi * curve.turns;
  // The largest derivative of the position by the phase is that at the beginning (the crossing of the eight).
  const double metres_per_rad =
      curve.eight ? core::sqrt(curve.a_m * curve.a_m + 4.0 * curve.b_m * curve.b_m) : curve.a_m;
  const double ramp_per_rate_s2 = kRampSteepest * metres_per_rad / acceleration_m_s2;
  rate_rad_s_ = curve.speed_m_s / metres_per_rad;
  if (rate_rad_s_ * rate_rad_s_ * ramp_per_rate_s2 > total_rad) {
    rate_rad_s_ = core::sqrt(total_rad / ramp_per_rate_s2);
  }
  ramp_s_ = ramp_per_rate_s2 * rate_rad_s_;
  cruise_s_ = total_rad / rate_rad_s_ - ramp_s_;
  const double most_rad = curve.eight ? core::kPi / 8.0 : core::kPi / 4.0;
  ramp_pieces_ = at_least(kRampPieces, rate_rad_s_ * ramp_s_ / most_rad);
  ramp_s_ = in_pieces(ramp_s_, ramp_pieces_);
  if (cruise_s_ < kShortestCruise_s) {
    cruise_s_ = 0.0;
  } else {
    cruise_pieces_ = at_least(1, rate_rad_s_ * cruise_s_ / most_rad);
    cruise_s_ = in_pieces(cruise_s_, cruise_pieces_);
  }
  rate_rad_s_ = total_rad / (ramp_s_ + cruise_s_);  // corrects for the rounding to whole microseconds
}

double CurveTimes::end_s(std::size_t piece) const {
  const double one_ramp_s = ramp_s_ / static_cast<double>(ramp_pieces_);
  if (piece <= ramp_pieces_) {
    return static_cast<double>(piece) * one_ramp_s;
  }
  if (piece < ramp_pieces_ + cruise_pieces_) {
    return ramp_s_ + cruise_s_ * static_cast<double>(piece - ramp_pieces_) / static_cast<double>(cruise_pieces_);
  }
  return ramp_s_ + cruise_s_ + one_ramp_s * static_cast<double>(piece - ramp_pieces_ - cruise_pieces_);
}

Node CurveTimes::at(double time_s) const {
  const double total_rad = 2.0 * core::kPi * curve_.turns;
  const double end_s = 2.0 * ramp_s_ + cruise_s_;
  Phase phase{.p = rate_rad_s_ * (time_s - 0.5 * ramp_s_), .p1 = rate_rad_s_};
  if (time_s < ramp_s_) {
    phase = ramped(time_s / ramp_s_, rate_rad_s_, ramp_s_);
  } else if (time_s > ramp_s_ + cruise_s_) {  // the ramp, time reversed
    const double left_s = end_s - time_s;
    phase = ramped((left_s > 0.0 ? left_s : 0.0) / ramp_s_, rate_rad_s_, ramp_s_);
    phase.p = total_rad - phase.p;
    phase.p2 = -phase.p2;
  }
  const core::SinCos<double> one = core::sin_cos_of(phase.p);
  Node node;
  add(node, 0, curve_.a_m, chain(one.sine, one.cosine, 1.0, phase));
  if (curve_.eight) {
    const core::SinCos<double> two = core::sin_cos_of(2.0 * phase.p);
    add(node, 1, curve_.b_m, chain(two.sine, 2.0 * two.cosine, 2.0, phase));
  } else {
    node.position[1] = curve_.b_m;
    add(node, 1, -curve_.b_m, chain(one.cosine, -one.sine, 1.0, phase));
  }
  return node;
}

}  // namespace m100::ref
