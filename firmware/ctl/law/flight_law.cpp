// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/flight_law.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/slope_limit.h"

namespace m100::ctl {
namespace {

constexpr double kSlopeSeen = 1.2601582175503392;  // tan(0.9 rad): beyond it the tangent is of no use

template <typename T>
T seen(T slope) {
  return core::clamp(slope, T(-kSlopeSeen), T(kSlopeSeen));
}

model::AltitudeGains altitude_gains(const model::Vehicle& vehicle) {
  return vehicle.altitude.design ? design_altitude(vehicle.climb, vehicle.altitude) : vehicle.altitude;
}

}  // namespace

template <typename T>
[[gnu::cold]] typename FlightLaw<T>::Axis FlightLaw<T>::make_axis(const mpc::GainTable<T>& table,
                                                                  const model::StickAxis& axis, mpc::Law law) {
  Axis made{.mpc = mpc::HorizontalMpc<T>(table, law), .predictor = mpc::DelayPredictor<T>(table.delay)};
  const InverseLags lags = inverse_lags(axis);
  made.first_lag_s = static_cast<T>(lags.first_s);
  made.second_lag_s2 = static_cast<T>(lags.second_s2);
  made.acts_s = static_cast<T>(effective_delay_s(axis));
  return made;
}

template <typename T>
[[gnu::cold]] FlightLaw<T>::FlightLaw(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables,
                                      const FlightLawOptions& options)
    : x_(make_axis(tables.x, model::flown_pitch(vehicle), options.horizontal)),
      y_(make_axis(tables.y, model::flown_roll(vehicle), options.horizontal)),
      height_(altitude_gains(vehicle)),
      yaw_(vehicle.yaw),
      combined_tangent_(core::tan(static_cast<T>(options.combined_tilt_limit_rad))),
      planner_(braking_of(vehicle, static_cast<double>(slope_limit())), tables, combined_tangent_),
      takes_paper_state_(options.paper_state) {
  M100_ASSERT(options.combined_tilt_limit_rad > 0.0 && options.combined_tilt_limit_rad < 0.5 * core::kPi);
  const model::StickAxis& climb = vehicle.climb;
  climb_lag_s_ =
      static_cast<T>(climb.transport_delay_s + (climb.time_constant_s > 0.0 ? climb.time_constant_s
                                                : climb.natural_frequency_rad_s > 0.0
                                                    ? 2.0 * climb.damping_ratio / climb.natural_frequency_rad_s
                                                    : 0.0));
}

template <typename T>
T FlightLaw<T>::solve(Axis& axis, const est::AxisEstimate<T>& estimate, const References& reference, bool constant,
                      T lead_gap_s, T applied_slope) {
  const mpc::GainTable<T>& table = axis.mpc.table();
  const T offset_slope = added_slope(applied_slope, estimate.input_offset_rad);
  const T slope = seen(core::tan(estimate.tilt_rad));
  axis.soon = predicted_slope(estimate, slope, axis.acts_s);
  problem_.state = axis.predictor.predict({.position_m = estimate.position_m,
                                           .velocity_m_s = estimate.velocity_m_s,
                                           .tilt_slope = slope,
                                           .tilt_slope_per_s = estimate.tilt_rate_rad_s * (T(1) + slope * slope),
                                           .disturbance_m_s2 = estimate.disturbance_m_s2,
                                           .input_offset_slope = offset_slope});
  problem_.previous_input_slope = applied_slope + offset_slope;
  problem_.disturbance_m_s2 = estimate.disturbance_m_s2;
  problem_.constant_reference = constant;

  const T per_acceleration = table.tilt_sign / table.acceleration_per_tilt;
  const T drag_per_s = table.drag_per_s;
  const T disturbance_m_s2 = estimate.disturbance_m_s2;
  const auto target = [=](const ref::AxisReference<T>& r) {
    return per_acceleration * (r.acceleration_m_s2 + drag_per_s * r.velocity_m_s - disturbance_m_s2);
  };
  constexpr double kStep_s = ref::kPredictionStep_s;
  const T per_difference = constant ? T(0) : axis.first_lag_s * static_cast<T>(0.5 / kStep_s);
  const T per_curvature = constant ? T(0) : axis.second_lag_s2 * static_cast<T>(1.0 / (kStep_s * kStep_s));
  const T per_gain = T(1) / table.input_gain;
  const T half_gap_s2 = T(0.5) * lead_gap_s * lead_gap_s;
  T now = target(reference[0]);
  T before = now + now - target(reference[1]);  // nothing is before the first stage: differences are one-sided there
  for (std::size_t k = 0; k < mpc::kHorizon; ++k) {
    const ref::AxisReference<T> r = reference[k + 1];
    const T after = target(r);
    const T input = now + per_difference * (after - before) + per_curvature * (after - T(2) * now + before);
    problem_.input_ref_slope[k] = input * per_gain;
    problem_.position_ref_m[k] = r.position_m;
    problem_.velocity_ref_m_s[k] = r.velocity_m_s;
    if (lead_gap_s != T(0)) {
      problem_.position_ref_m[k] += lead_gap_s * r.velocity_m_s + half_gap_s2 * r.acceleration_m_s2;
      problem_.velocity_ref_m_s[k] += lead_gap_s * r.acceleration_m_s2;
    }
    problem_.tilt_ref_slope[k] = after;
    before = now;
    now = after;
  }
  axis.mpc.solve(problem_, solution_);
  axis.path = solution_.path;
  axis.changes = solution_.changes;
  return solution_.input_slope[0] - offset_slope;
}

template <typename T>
core::Slope<T> FlightLaw<T>::slopes(const est::Estimate<T>& estimate, const ref::Window<T>& reference,
                                    const core::Slope<T>& applied_command, T step_s) {
  if (takes_paper_state_) {
    paper_state_.update(estimate, reference, step_s);
  }
  const est::AxisEstimate<T>& state_x = takes_paper_state_ ? paper_state_.x() : estimate.x;
  const est::AxisEstimate<T>& state_y = takes_paper_state_ ? paper_state_.y() : estimate.y;
  T slope_x = solve(x_, state_x, reference.x, reference.constant, T(0), applied_command.x);
  const T gap_s =
      y_.predictor.lead() == x_.predictor.lead() ? T(0) : core::seconds<T>(y_.predictor.lead() - x_.predictor.lead());
  T slope_y = solve(y_, state_y, reference.y, reference.constant, gap_s, applied_command.y);
  report_ = {.path_x = x_.path, .path_y = y_.path, .changes = x_.changes + y_.changes, .fallback = fallback()};
  if (fallback()) {
    slope_x = x_.fallback.slope(estimate.x, reference.x[0], x_.mpc.table(), fallback_per_s_, step_s);
    slope_y = y_.fallback.slope(estimate.y, reference.y[0], y_.mpc.table(), fallback_per_s_, step_s);
  }

  const T most = max_slope(x_.soon, y_.soon, combined_tangent_);
  const T size = core::sqrt(slope_x * slope_x + slope_y * slope_y);
  if (size > most) {
    slope_x *= most / size;
    slope_y *= most / size;
    report_.tilt_limited = true;
  }
  return {.x = slope_x, .y = slope_y};
}

template <typename T>
Command<T> FlightLaw<T>::update(const est::Estimate<T>& estimate, const ref::Window<T>& reference,
                                const Command<T>& applied_command, core::Duration elapsed, bool solves) {
  M100_ASSERT(elapsed >= core::Duration(0));
  const core::SinCos<T>& heading = estimate.heading();
  const core::Slope<T> commanded = commanded_slope_.at(applied_command.roll_rad, applied_command.pitch_rad, heading);
  const core::Slope<T> applied_slope{.x = seen(commanded.x), .y = seen(commanded.y)};
  // The delay lines hold tangents of the commands to the attitude loop, without the offset, which may still change.
  for (int ticks = time_.take(elapsed, static_cast<int>(mpc::DelayPredictor<T>::kCapacity)); ticks > 0; --ticks) {
    x_.predictor.sent(applied_slope.x);
    y_.predictor.sent(applied_slope.y);
  }
  if (solves) {
    attitude_ = core::attitude_of(slopes(estimate, reference, applied_slope, core::seconds<T>(elapsed)),
                                  estimate.yaw_rad, heading);
  }
  const ref::AxisReference<T>& height = reference.height;
  const HeightReference<T> wanted{.height_m = height.position_m,
                                  .climb_m_s = height.velocity_m_s,
                                  .climb_command_m_s = height.velocity_m_s + climb_lag_s_ * height.acceleration_m_s2};
  Command<T> command;
  command.roll_rad = attitude_.roll_rad;
  command.pitch_rad = attitude_.pitch_rad;
  command.climb_m_s = height_.update(wanted, estimate.height_m, estimate.climb_m_s, core::seconds<T>(elapsed));
  command.yaw_rate_rad_s = yaw_.update(reference.yaw_rad, reference.yaw_rate_rad_s, estimate.yaw_rad);
  return command;
}

template <typename T>
T FlightLaw<T>::slope_limit() const {
  T least = combined_tangent_ * static_cast<T>(0.7071067811865476);
  for (const Axis* axis : {&x_, &y_}) {
    const mpc::GainTable<T>& table = axis->mpc.table();
    const T up = table.input_gain * table.input_max_slope;
    const T down = -table.input_gain * table.input_min_slope;
    least = up < least ? up : least;
    least = down < least ? down : least;
  }
  return least;
}

template <typename T>
void FlightLaw<T>::reset() {
  x_.mpc.reset();
  y_.mpc.reset();
  x_.fallback.reset();
  y_.fallback.reset();
  fallback_per_s_ = T(0);
  height_.reset();
  planner_.reset();
  paper_state_.reset();
}

template class FlightLaw<float>;
template class FlightLaw<double>;

}  // namespace m100::ctl
