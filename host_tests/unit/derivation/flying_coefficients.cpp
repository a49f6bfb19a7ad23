// SPDX-License-Identifier: BSD-3-Clause
// flying_coefficients: prints the coefficients that fly as JSON, for firmware/est/derivation/derive.py.
#include <array>
#include <iostream>

#include "firmware/companion/files/text/json.h"
#include "firmware/est/filter/axis_filter.h"
#include "firmware/model/axis_step.h"
#include "firmware/model/vehicle.h"
#include "host_tests/lab/gains/axis_model.h"

namespace {

using namespace m100;
using Filter = est::AxisFilter<double>;

struct Case {
  const char* name;
  model::StickAxis axis;
  double tilt_gain, linear_drag_per_s, quadratic_drag_per_m;
};

const std::array kCases{
    Case{"paper, second order", {.natural_frequency_rad_s = 7.25, .damping_ratio = 0.75}, 1.0, 0.0, 0.0},
    Case{"slow, drag",
         {.natural_frequency_rad_s = 3.5, .damping_ratio = 0.375, .lead_zero_s = 0.0625},
         0.875,
         0.25,
         0.03125},
    Case{"fast, well damped", {.natural_frequency_rad_s = 14.0, .damping_ratio = 0.9375}, 1.125, 0.5, 0.0},
    Case{
        "overdamped", {.natural_frequency_rad_s = 6.0, .damping_ratio = 1.25, .lead_zero_s = 0.03125}, 1.0, 0.125, 0.0},
    Case{"first order", {.time_constant_s = 0.40625}, 1.0, 0.0, 0.0},
    Case{"first order, lead zero", {.time_constant_s = 0.21875, .lead_zero_s = 0.09375}, 1.0, 0.25, 0.015625}};

Json parameters_of(const Case& one, double step_s) {
  return {{"name", one.name},
          {"step_s", step_s},
          {"frequency", one.axis.natural_frequency_rad_s},
          {"damping", one.axis.damping_ratio},
          {"time_constant", one.axis.time_constant_s},
          {"lead_zero", one.axis.lead_zero_s},
          {"gravity", one.tilt_gain * model::kGravity_m_s2},
          {"drag", one.linear_drag_per_s},
          {"drag2", one.quadratic_drag_per_m}};
}

Json axis_step_of(const Case& one, double step_s) {
  const model::AxisStep step = model::axis_step(one.axis, step_s);
  Json out = parameters_of(one, step_s);
  out.update({{"oo", step.oo},
              {"o_r", step.o_r},
              {"o_u", step.o_u},
              {"o_jump", step.o_jump},
              {"ro", step.ro},
              {"rr", step.rr},
              {"r_u", step.r_u},
              {"r_next", step.r_next},
              {"r_jump", step.r_jump}});
  return out;
}

Json predictor_of(const Case& one, double step_s) {
  model::Vehicle vehicle;
  vehicle.pitch = one.axis;
  vehicle.translation.tilt_gain = one.tilt_gain;
  vehicle.translation.linear_drag_per_s = one.linear_drag_per_s;
  const lab::gains::DiscreteAxis discrete =
      lab::gains::discretise(lab::gains::continuous_axis(vehicle, lab::gains::Axis::kX), step_s);
  Json out = parameters_of(one, step_s);
  out.update({{"a", Json::array()}, {"b", Json::array()}, {"bd", Json::array()}});
  for (Eigen::Index row = 0; row < discrete.a.rows(); ++row) {
    Json line = Json::array();
    for (Eigen::Index column = 0; column < discrete.a.cols(); ++column) {
      line.push_back(static_cast<double>(discrete.a(row, column)));
    }
    out["a"].push_back(line);
    out["b"].push_back(static_cast<double>(discrete.b(row)));
    out["bd"].push_back(static_cast<double>(discrete.bd(row)));
  }
  return out;
}

/// One prediction from the filter's start, whose covariance is diagonal: its state and covariance, and the innovation
/// variance of a pose. The tilt is small: the filter's tangent is then exact to double precision.
Json observer_of(const Case& one) {
  constexpr double kSpeed_m_s = 1.5, kTilt_rad = 0.03125, kCommand_rad = 0.125, kAge_s = 0.03125;
  est::AxisModel model{.attitude = one.axis,
                       .tilt_gain = one.tilt_gain,
                       .linear_drag_per_s = one.linear_drag_per_s,
                       .quadratic_drag_per_m = one.quadratic_drag_per_m,
                       .noise = {}};
  Filter filter(model);
  filter.start(kTilt_rad);
  filter.reset_position(0.5, kSpeed_m_s, 0.0, {});
  const model::EstimatorNoise& noise = model.noise;
  Json out = parameters_of(one, est::kTick_s);
  out.update({{"state", {0.5, kSpeed_m_s, kTilt_rad, 0.0, 0.0, 0.0}},
              {"command", kCommand_rad},
              {"age_s", kAge_s},
              {"pose_variance", noise.pose_position_sigma_m * noise.pose_position_sigma_m}});
  for (int i = 0; i < Filter::kStates; ++i) {
    out["covariance"].push_back(filter.covariance(i, i));
  }
  for (const double sigma :
       {noise.position_process_m, noise.velocity_process_m_s, noise.tilt_process_rad, noise.tilt_rate_process_rad_s,
        noise.disturbance_process_m_s2, noise.input_offset_process_rad}) {
    out["process"].push_back(sigma * sigma * est::kTick_s);
  }
  filter.predict({.now = kCommand_rad, .before = kCommand_rad, .after = kCommand_rad});
  for (int i = 0; i < Filter::kStates; ++i) {
    out["predicted"].push_back(filter.state(static_cast<Filter::StateIndex>(i)));
    Json line = Json::array();
    for (int j = 0; j < Filter::kStates; ++j) {
      line.push_back(filter.covariance(i, j));
    }
    out["predicted_covariance"].push_back(line);
  }
  out["innovation_variance"] = filter.test_pose(0.5, kAge_s, 0.0, 0.0).variance_m2;
  return out;
}

}  // namespace

int main() {
  Json out = {{"axis_step", Json::array()}, {"predictor", Json::array()}, {"observer", Json::array()}};
  for (const Case& one : kCases) {
    for (const double step_s : {0.01, 0.1}) {
      out["axis_step"].push_back(axis_step_of(one, step_s));
      out["predictor"].push_back(predictor_of(one, step_s));
    }
    out["observer"].push_back(observer_of(one));
  }
  std::cout << out.sorted().dump(1) << '\n';
  return 0;
}
