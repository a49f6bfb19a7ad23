// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/paper.h"
#include "firmware/model/vehicle.h"

namespace m100::model {

/// The aircraft as the paper prints it (Tables I and II, III-B), for comparison, tests and examples. Roll and pitch are
/// of second order, yaw rate and climb of first order. Their gains are folded into the scales.
constexpr Vehicle paper_vehicle() {
  Vehicle v;
  v.roll = StickAxis{.scale_per_count = paper::kScaleRoll_rad_per_count.experiment * paper::kRollSecond.gain,
                     .natural_frequency_rad_s = paper::kRollSecond.natural_frequency_rad_s,
                     .damping_ratio = paper::kRollSecond.damping_ratio,
                     .dead_zone_counts = paper::kTiltDeadZone_vrc,
                     .dead_zone_shape = DeadZoneShape::kJump,
                     .trim_counts = paper::kRollBalance_vrc - paper::kNeutral_vrc};
  v.pitch = StickAxis{.scale_per_count = paper::kScalePitch_rad_per_count.experiment * paper::kPitchSecond.gain,
                      .natural_frequency_rad_s = paper::kPitchSecond.natural_frequency_rad_s,
                      .damping_ratio = paper::kPitchSecond.damping_ratio,
                      .dead_zone_counts = paper::kTiltDeadZone_vrc,
                      .dead_zone_shape = DeadZoneShape::kJump,
                      .trim_counts = paper::kPitchBalance_vrc - paper::kNeutral_vrc};
  v.yaw_rate = StickAxis{.scale_per_count = paper::kScaleYawRate_rad_s_per_count.experiment * paper::kYawRateFirst.gain,
                         .time_constant_s = paper::kYawRateFirst.time_constant_s,
                         .dead_zone_counts = paper::kYawRateDeadZone_vrc,
                         .dead_zone_shape = DeadZoneShape::kJump};
  v.climb = StickAxis{.scale_per_count = paper::kScaleClimb_m_s_per_count.experiment * paper::kClimbFirst.gain,
                      .time_constant_s = paper::kClimbFirst.time_constant_s,
                      .dead_zone_counts = paper::kClimbDeadZone_vrc,
                      .dead_zone_shape = DeadZoneShape::kJump};
  return v;
}

/// The configuration that the paper flew: the law predicts with axes of first order without delay ([design]; III-D.2),
/// the observer with those of second order (III-E.1; Table II); scales of Table I, dead zones of III-B.5, height PID of
/// III-E.2, and what its authors published later for this aircraft. PAPER.md has it row by row. Trims and noise are
/// those of `aircraft`.
///
/// The authors' input weight and limit count a tilt before the static gain k of the first order, ours one after it: r /
/// k^2, k limit. We have one weight and limit for both axes: the mean, 7 % from either.
constexpr Vehicle paper_configuration(const Vehicle& aircraft) {
  const auto axis = [](const StickAxis& trimmed, double scale, double dead_zone) {
    return StickAxis{.scale_per_count = scale,
                     .dead_zone_counts = dead_zone,
                     .dead_zone_shape = DeadZoneShape::kJump,
                     .trim_counts = trimmed.trim_counts};
  };
  const auto first = [](StickAxis out, const paper::FirstOrder& model) {
    out.scale_per_count *= model.gain;
    out.time_constant_s = model.time_constant_s;
    return out;
  };
  const auto second = [](StickAxis out, const paper::SecondOrder& model) {
    out.scale_per_count *= model.gain;
    out.natural_frequency_rad_s = model.natural_frequency_rad_s;
    out.damping_ratio = model.damping_ratio;
    return out;
  };
  constexpr double kRollGain2 = paper::kRollFirst.gain * paper::kRollFirst.gain;
  constexpr double kPitchGain2 = paper::kPitchFirst.gain * paper::kPitchFirst.gain;
  const StickAxis roll = axis(aircraft.roll, paper::kScaleRoll_rad_per_count.experiment, paper::kTiltDeadZone_vrc);
  const StickAxis pitch = axis(aircraft.pitch, paper::kScalePitch_rad_per_count.experiment, paper::kTiltDeadZone_vrc);
  Vehicle v = aircraft;
  v.roll = second(roll, paper::kRollSecond);
  v.pitch = second(pitch, paper::kPitchSecond);
  v.yaw_rate = first(axis(v.yaw_rate, paper::kScaleYawRate_rad_s_per_count.experiment, paper::kYawRateDeadZone_vrc),
                     paper::kYawRateFirst);
  v.climb =
      first(axis(v.climb, paper::kScaleClimb_m_s_per_count.experiment, paper::kClimbDeadZone_vrc), paper::kClimbFirst);
  v.translation.linear_drag_per_s = paper::kDrag_per_s;
  v.translation.tilt_limit_rad = paper::kInputLimit_rad * 0.5 * (paper::kRollFirst.gain + paper::kPitchFirst.gain);
  v.mpc = MpcWeights{.position = paper::kPositionWeight,
                     .velocity = paper::kVelocityWeight,
                     .tilt = paper::kTiltWeight,
                     .input = 0.5 * (paper::kRollInputWeight / kRollGain2 + paper::kPitchInputWeight / kPitchGain2),
                     .input_rate = 0.5 * paper::kInputRateWeight * (1.0 / kRollGain2 + 1.0 / kPitchGain2)};
  v.design = v.robust = {};
  v.design.roll = first(roll, paper::kRollFirst);
  v.design.pitch = first(pitch, paper::kPitchFirst);
  v.altitude = AltitudeGains{.design = false,
                             .proportional_per_s = paper::kAltitudeKp,
                             .integral_per_s2 = paper::kAltitudeKi,
                             .derivative = paper::kAltitudeKd,
                             .integral_min_m_s = -paper::kAltitudeIntegralLimit,
                             .integral_max_m_s = paper::kAltitudeIntegralLimit,
                             .climb_limit_m_s = aircraft.altitude.climb_limit_m_s};
  v.yaw.proportional_per_s = paper::kYawGain_per_s;
  return v;
}

}  // namespace m100::model
