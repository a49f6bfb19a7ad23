// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/paper/configuration.h"

#include <initializer_list>
#include <sstream>

#include "firmware/core/maths.h"
#include "firmware/model/paper.h"
#include "firmware/mpc/problem.h"

namespace m100::lab::identify::paper {
namespace {

std::string numbers(std::initializer_list<double> values) {
  std::ostringstream out;
  out.precision(4);
  for (const double value : values) {
    out << (out.tellp() > 0 ? ", " : "") << value;
  }
  return out.str();
}

std::string second_order(const model::StickAxis& roll, const model::StickAxis& pitch) {
  return numbers({roll.natural_frequency_rad_s, pitch.natural_frequency_rad_s}) + " rad/s; damping " +
         numbers({roll.damping_ratio, pitch.damping_ratio});
}

}  // namespace

std::vector<ConfigurationRow> configuration_rows(const model::Vehicle& flown) {
  using namespace model::paper;
  const std::string none = "-";
  const std::string zones = numbers({kTiltDeadZone_vrc, kClimbDeadZone_vrc, kYawRateDeadZone_vrc});
  const std::string printed_pid =
      numbers({kAltitudeKp, kAltitudeKi, kAltitudeKd}) + "; +-" + numbers({kAltitudeIntegralLimit});
  const std::string later_pid =
      numbers({kAltitudeKpLater, kAltitudeKiLater, kAltitudeKdLater}) + "; +-" + numbers({kAltitudeIntegralLimitLater});
  const model::AltitudeGains& pid = flown.altitude;
  return {
      {"weights of position, velocity, tilt", none, numbers({kPositionWeight, kVelocityWeight, kTiltWeight}),
       numbers({flown.mpc.position, flown.mpc.velocity, flown.mpc.tilt})},
      {"input weight, roll, pitch", none, numbers({kRollInputWeight, kPitchInputWeight}) + " before the gain",
       numbers({flown.mpc.input}) + " after it (r / k^2), one for both"},
      {"input rate weight", none, numbers({kInputRateWeight}), numbers({flown.mpc.input_rate}) + " after the gain"},
      {"input limit [deg]", none, numbers({kInputLimit_rad * core::kRadian_deg}),
       numbers({flown.translation.tilt_limit_rad * core::kRadian_deg}) + " after the gain"},
      {"horizon", numbers({kHorizon}) + " steps", "20 steps of 0.1 s",
       numbers({static_cast<double>(mpc::kHorizon)}) + " steps of " + numbers({mpc::kPredictionStep_s}) + " s"},
      {"law's model: lag of roll, pitch [s]",
       numbers({kRollFirst.time_constant_s, kPitchFirst.time_constant_s}) + "; Table II: 0.472, " +
           numbers({kPitchTimeConstantTable2_s}),
       "0.472, 0.411", numbers({flown.design.roll.time_constant_s, flown.design.pitch.time_constant_s})},
      {"its gain k", numbers({kRollFirst.gain, kPitchFirst.gain}), "1.673, 1.575",
       numbers({flown.design.roll.scale_per_count / kScaleRoll_rad_per_count.experiment,
                flown.design.pitch.scale_per_count / kScalePitch_rad_per_count.experiment})},
      {"observer's model: roll, pitch",
       numbers({kRollSecond.natural_frequency_rad_s, kPitchSecond.natural_frequency_rad_s}) + " rad/s; damping " +
           numbers({kRollSecond.damping_ratio, kPitchSecond.damping_ratio}),
       "7.07, 7.07 rad/s; damping 0.72, 0.76", second_order(flown.roll, flown.pitch)},
      {"its gain", numbers({kRollSecond.gain, kPitchSecond.gain}), "0.8, 0.84",
       numbers({flown.roll.scale_per_count / kScaleRoll_rad_per_count.experiment,
                flown.pitch.scale_per_count / kScalePitch_rad_per_count.experiment})},
      {"observer's noises", none, "force 0.1, position 0.001, attitude 0.01", "ours"},
      {"law's position, velocity", "motion capture, filtered (MSF)", "odometry", "our observer's"},
      {"law's tilt", "x(t0)", "odometry, not the filter", "measured"},
      {"integral of position: gain, limit, ball", none,
       numbers({kIntegralGain_per_s3, kIntegralLimit_m_s, kIntegralBall_m}),
       numbers({kIntegralGain_per_s3, kIntegralLimit_m_s, kIntegralBall_m})},
      {"acceleration of the reference", none, "not used", "not used"},
      {"drag [1/s]", none, numbers({kDrag_per_s}) + "; observer 0.01", numbers({flown.translation.linear_drag_per_s})},
      {"mass [kg]", numbers({kMass_kg}), "3.29", numbers({flown.translation.mass_kg})},
      {"dead zones: tilt, height, yaw [counts]", zones, "height 39.6",
       numbers({flown.roll.dead_zone_counts, flown.climb.dead_zone_counts, flown.yaw_rate.dead_zone_counts})},
      {"sticks inside", "to the edge", none, "to the first whole count outside, no remainder"},
      {"trims of roll, pitch", numbers({kRollBalance_vrc, kPitchBalance_vrc}), none, "the vehicle file's, not learned"},
      {"height PID", printed_pid, later_pid,
       numbers({pid.proportional_per_s, pid.integral_per_s2, pid.derivative}) + "; +-" +
           numbers({pid.integral_max_m_s})},
      {"yaw gain [1/s]", "K, no number", numbers({kYawGain_per_s}), numbers({flown.yaw.proportional_per_s})},
      {"set-point planner, reaction to a limit cycle", none, none, "off"},
      {"commands [Hz]", "100", "100", "100"},
  };
}

}  // namespace m100::lab::identify::paper
