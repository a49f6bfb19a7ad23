// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/axis_model.h"

#include <cmath>
#include <stdexcept>

#include "firmware/core/assert.h"
#include "firmware/model/exponential.h"
#include "firmware/model/tilt_limit.h"
#include "firmware/mpc/problem.h"

namespace m100::lab::gains {

ContinuousAxis continuous_axis(const model::Vehicle& vehicle, Axis axis) {
  const model::StickAxis& attitude = attitude_of(vehicle, axis);
  ContinuousAxis out;
  out.states = attitude.is_first_order() ? 3 : 4;
  out.tilt_sign = axis == Axis::kX ? 1 : -1;
  out.acceleration_per_tilt = Real(model::kGravity_m_s2) * Real(vehicle.translation.tilt_gain);
  out.drag_per_s = vehicle.translation.linear_drag_per_s;
  const auto n = static_cast<Eigen::Index>(out.states);
  out.f = Matrix::Zero(n, n);
  out.g = Vector::Zero(n);
  out.gd = Vector::Zero(n);
  const Real pull = out.tilt_sign * out.acceleration_per_tilt;
  const Real zero = attitude.lead_zero_s;
  out.f(0, 1) = 1;
  out.f(1, 1) = -out.drag_per_s;
  out.gd(1) = 1;
  if (attitude.is_first_order()) {
    const Real tau = attitude.time_constant_s;
    const Real share = zero / tau;  // tilt = (1 - share) chi + share u
    if (std::abs(1 - share) < Real(0.05)) {
      throw std::domain_error("the lead zero cancels the axis' time constant");
    }
    out.f(1, 2) = pull * (1 - share);
    out.g(1) = pull * share;
    out.f(2, 2) = -1 / tau;
    out.g(2) = 1 / tau;
    return out;
  }
  const Real w = attitude.natural_frequency_rad_s;
  const Real damping = attitude.damping_ratio;
  if (!(w > 0)) {
    throw std::domain_error("the axis has neither a time constant nor a natural frequency");
  }
  if (1 - 2 * damping * w * zero + w * w * zero * zero < Real(0.05)) {
    throw std::domain_error("the lead zero cancels a pole of the axis");
  }
  out.f(1, 2) = pull;
  out.f(1, 3) = pull * zero;
  out.f(2, 3) = 1;
  out.f(3, 2) = -w * w;
  out.f(3, 3) = -2 * damping * w;
  out.g(3) = w * w;
  return out;
}

DiscreteAxis discretise(const ContinuousAxis& axis, Real step_s) {
  const Eigen::Index n = axis.f.rows();
  M100_ASSERT(step_s >= 0);
  M100_ASSERT(n <= Eigen::Index(mpc::kMaxStates) && axis.f.cols() == n && axis.g.size() == n && axis.gd.size() == n);
  constexpr std::size_t kSize = mpc::kMaxStates + 2;  // the states, the command and the disturbance
  using Square = model::SquareMatrix<Real, kSize>;
  using Augmented = Eigen::Matrix<Real, Eigen::Index(kSize), Eigen::Index(kSize), Eigen::RowMajor>;
  Square entries{};
  Eigen::Map<Augmented> augmented(entries.data());
  augmented.topLeftCorner(n, n) = axis.f * step_s;
  augmented.block(0, n, n, 1) = axis.g * step_s;
  augmented.block(0, n + 1, n, 1) = axis.gd * step_s;
  // The default series norm of 1 would change the last digits of all tables that have been made.
  const Square exact = model::exponential<kSize>(entries, Real(0.25));
  const Eigen::Map<const Augmented> e(exact.data());
  return {.a = e.topLeftCorner(n, n), .b = e.block(0, n, n, 1), .bd = e.block(0, n + 1, n, 1)};
}

AxisQp axis_qp(const model::Vehicle& vehicle, Axis axis) {
  const ContinuousAxis continuous = continuous_axis(vehicle, axis);
  AxisQp out;
  out.step = discretise(continuous, Real(mpc::kPredictionStep_s));
  out.q = Vector::Zero(continuous.f.rows());
  out.q(0) = vehicle.mpc.position;
  out.q(1) = vehicle.mpc.velocity;
  out.q(2) = vehicle.mpc.tilt;
  out.r = vehicle.mpc.input;
  out.rd = vehicle.mpc.input_rate;
  out.p = riccati(out.step.a, out.step.b, out.q.asDiagonal(), out.r);
  out.u_max = model::slope_at_limit(vehicle.translation.tilt_limit_rad);
  out.u_min = -out.u_max;
  out.input_gain = continuous.input_gain;
  out.tilt_sign = continuous.tilt_sign;
  out.acceleration_per_tilt = continuous.acceleration_per_tilt;
  out.drag_per_s = continuous.drag_per_s;
  return out;
}

}  // namespace m100::lab::gains
