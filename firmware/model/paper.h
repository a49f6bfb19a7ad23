// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::model::paper {

// The numbers of Sa et al., "Dynamic System Identification, and Control for a cost effective open-source VTOL MAV",
// each once, with its source. Its identified models do not fly by default; the default vehicle is from a measured log.

struct FirstOrder {
  double gain;
  double time_constant_s;
};
struct SecondOrder {
  double gain;
  double damping_ratio;
  double natural_frequency_rad_s;
};
struct Experiment {
  double experiment;
  double simulator;
};

// Table I: Virtual RC scaling parameters, experiment and simulator.
inline constexpr Experiment kScaleRoll_rad_per_count{8.65e-4, 8.35e-4};
inline constexpr Experiment kScalePitch_rad_per_count{8.44e-4, 8.23e-4};
inline constexpr Experiment kScaleYawRate_rad_s_per_count{2.24e-3, 3.23e-3};
inline constexpr Experiment kScaleClimb_m_s_per_count{2.65e-3, 3.02e-3};
/// III-D.1: plain mapping of +-30 degrees on +-660 counts.
inline constexpr double kScaleLinear_rad_per_count = 7.93e-4;

// III-D.2, transfer functions; k and tau follow from them. Static gains of 1.6 contradict the second-order gains of
// about 1 found on the same data: the input is scaled to rad already, so about 1 is right. Kept for comparison only.
inline constexpr FirstOrder kRollFirst{.gain = 3.544 / 2.118, .time_constant_s = 1.0 / 2.118};
/// Table II prints tau = 0.472 s, the roll value; the transfer function 3.827/(s + 2.43) gives 0.4115 s.
inline constexpr FirstOrder kPitchFirst{.gain = 3.827 / 2.43, .time_constant_s = 1.0 / 2.43};
inline constexpr double kPitchTimeConstantTable2_s = 0.472;
inline constexpr SecondOrder kRollSecond{.gain = 0.975, .damping_ratio = 0.512, .natural_frequency_rad_s = 5.200};
inline constexpr SecondOrder kPitchSecond{.gain = 1.052, .damping_ratio = 0.573, .natural_frequency_rad_s = 5.239};

// III-D.3. The text gives 5.642/(s + 5.268), so tau = 0.190 s and k = 1.071; Table II prints tau = 0.161 s, k = 1.057,
// which is 6.57/(s + 6.21): the two are different fits. We keep both and prefer the text, which is the one the
// controller of the paper was built on.
inline constexpr FirstOrder kYawRateFirst{.gain = 5.642 / 5.268, .time_constant_s = 1.0 / 5.268};
inline constexpr FirstOrder kYawRateFirstTable2{.gain = 1.057, .time_constant_s = 0.161};
inline constexpr SecondOrder kYawRateSecond{.gain = 1.079, .damping_ratio = 1.898, .natural_frequency_rad_s = 23.448};
inline constexpr FirstOrder kClimbFirst{.gain = 3.342 / 2.99, .time_constant_s = 1.0 / 2.99};
inline constexpr SecondOrder kClimbSecond{.gain = 1.024, .damping_ratio = 0.718, .natural_frequency_rad_s = 4.985};

// III-B.3, trims of the sticks; III-B.5, dead zones (half widths); III-B.3, stick travel.
inline constexpr double kNeutral_vrc = 1024.0;
inline constexpr double kTravel_vrc = 660.0;
inline constexpr double kRollBalance_vrc = 1080.0;
inline constexpr double kPitchBalance_vrc = 998.0;
inline constexpr double kTiltDeadZone_vrc = 19.8;
inline constexpr double kClimbDeadZone_vrc = 30.5;
inline constexpr double kYawRateDeadZone_vrc = 30.5;

// III-E.2, height PID.
inline constexpr double kAltitudeKp = 1.963;
inline constexpr double kAltitudeKi = 6.190;
inline constexpr double kAltitudeKd = 0.156;
inline constexpr double kAltitudeIntegralLimit = 0.2;

// III-E.1 and IV.
inline constexpr int kHorizon = 20;
inline constexpr double kMass_kg = 3.3;
inline constexpr double kPayload_kg = 0.92;
inline constexpr double kFanWindLow_m_s = 11.0;
inline constexpr double kFanWindHigh_m_s = 11.5;

// The paper prints neither weights nor limits. Its authors published them for this aircraft half a year later, with the
// paper's time constants and gains: ethz-asl/mav_control_rw, "tests for DJI M100", January 2017,
// mav_linear_mpc/resources/linear_mpc_flourish.yaml. Inputs there are tilts before the static gain of the model.
inline constexpr double kPositionWeight = 28.0;
inline constexpr double kVelocityWeight = 0.001;
inline constexpr double kTiltWeight = 64.0;
inline constexpr double kRollInputWeight = 143.28;
inline constexpr double kPitchInputWeight = 145.27;
inline constexpr double kInputRateWeight = 0.15;
inline constexpr double kInputLimit_rad = 0.3234;  ///< 18.53 degrees
inline constexpr double kYawGain_per_s = 1.9;
inline constexpr double kIntegralGain_per_s3 = 0.2;  ///< Ki_xy: acceleration per integral of the position's error
inline constexpr double kIntegralLimit_m_s = 2.0;    ///< position_error_integration_limit
inline constexpr double kIntegralBall_m = 0.4;       ///< antiwindup_ball
inline constexpr double kDrag_per_s = 0.08;
// The height PID of the same file, which does not fly: III-E.2 prints another.
inline constexpr double kAltitudeKpLater = 1.7114;
inline constexpr double kAltitudeKiLater = 6.1906;
inline constexpr double kAltitudeKdLater = 0.7363;
inline constexpr double kAltitudeIntegralLimitLater = 0.12;

/// One column of the results table ("Control performance summary"): root mean squares from from_s to to_s; a negative
/// number stands for a cell the paper leaves empty.
struct ResultColumn {
  double pose_m, x_m, y_m, z_m, roll_deg, pitch_deg, yaw_deg, from_s, to_s;
};
inline constexpr ResultColumn kHoverCalm{0.039, 0.021, 0.016, 0.029, 0.392, 0.618, 1.087, 15, 75};
inline constexpr ResultColumn kHoverWind{0.041, 0.027, 0.015, 0.026, 1.044, 0.697, 1.844, 15, 75};
inline constexpr ResultColumn kStepCalm{0.394, 0.259, 0.295, 0.034, -1, -1, 1.141, 20, 120};
inline constexpr ResultColumn kStepWind{0.266, 0.127, 0.226, 0.059, -1, -1, 2.165, 20, 120};
inline constexpr ResultColumn kTrajectoryCalm{0.080, 0.058, 0.043, 0.035, -1, -1, 1.539, 30, 80};
inline constexpr ResultColumn kTrajectoryWind{0.103, 0.066, 0.059, 0.053, -1, -1, 2.876, 20, 70};
inline constexpr ResultColumn kTrajectorySimulator{0.108, 0.047, 0.053, 0.082, -1, -1, 26.267, 5, 100};

}  // namespace m100::model::paper
