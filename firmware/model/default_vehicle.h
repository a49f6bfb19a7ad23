// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/paper.h"
#include "firmware/model/vehicle.h"

namespace m100::model {

/// The aircraft as the paper prints it (Tables I and II, III-B): for comparison, and as the default starting point of
/// an identification. Second-order attitude with the second-order gains folded into the scale.
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

}  // namespace m100::model
