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

/// The configuration that the paper flew: axes of first order without delay, as printed (Table I, III-D.2, III-D.3),
/// dead zones of III-B.5, the input weight of its authors' code, and the height PID of III-E.2. Trims, limits, noise
/// and yaw gain are those of `aircraft`.
constexpr Vehicle paper_configuration(const Vehicle& aircraft) {
  const auto axis = [](const StickAxis& trimmed, double scale, const paper::FirstOrder& model, double dead_zone) {
    return StickAxis{.scale_per_count = scale * model.gain,
                     .time_constant_s = model.time_constant_s,
                     .dead_zone_counts = dead_zone,
                     .dead_zone_shape = DeadZoneShape::kJump,
                     .trim_counts = trimmed.trim_counts};
  };
  Vehicle v = aircraft;
  v.roll = axis(v.roll, paper::kScaleRoll_rad_per_count.experiment, paper::kRollFirst, paper::kTiltDeadZone_vrc);
  v.pitch = axis(v.pitch, paper::kScalePitch_rad_per_count.experiment, paper::kPitchFirst, paper::kTiltDeadZone_vrc);
  v.yaw_rate = axis(v.yaw_rate, paper::kScaleYawRate_rad_s_per_count.experiment, paper::kYawRateFirst,
                    paper::kYawRateDeadZone_vrc);
  v.climb = axis(v.climb, paper::kScaleClimb_m_s_per_count.experiment, paper::kClimbFirst, paper::kClimbDeadZone_vrc);
  v.mpc = MpcWeights{.input = paper::kInputWeight};
  v.design = v.robust = {};  // otherwise the law would predict with the aircraft's own design
  v.altitude = AltitudeGains{.design = false, .climb_limit_m_s = aircraft.altitude.climb_limit_m_s};
  return v;
}

}  // namespace m100::model
