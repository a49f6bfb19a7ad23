// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"

namespace m100::lab::excite {

// Stick movements that distinguish the candidate effects of a residual, and a forecast of how well they do.

/// The request for a manoeuvre. Amplitudes are in counts from the trim, lengths in m from the start of the manoeuvre.
struct InputDesign {
  std::string axis = "roll";   ///< "roll" or "pitch"; "climb" or "yaw_rate", see `rate`
  std::string kind = "mixed";  ///< "doublet", "3211", "chirp", "mixed" or "sweep"
  double amplitude_counts = 200.0;
  double duration_s = 40.0;
  double fence_m = 8.0;
  double brake_m_s2 = 2.0;  ///< deceleration that the abort assumes
  /// The response is a speed (climb [m/s], yaw rate [rad/s]), and the fence limits its integral: height [m] or heading
  /// [rad]. Otherwise the response is a tilt, and the acceleration is g times its tangent.
  bool rate = false;
  /// Unforeseen disturbance along the axis, assumed to act all the time: an acceleration, or for a rate axis a speed
  /// [m/s, rad/s]. 0.3 m/s^2 is a trim error of 30 counts, or a wind that changes by 1 m/s at a drag of 0.3 1/s.
  double disturbance = 0.3;
  double air = 0.0045;  ///< root mean square of the response with a resting stick, in its unit; memory 0.3 s
};

struct Manoeuvre {
  double period_s = 0.02;
  std::vector<double> stick_counts;  ///< from the trim
  std::vector<int> piece;            ///< numbered from 1; 0: the pilot (in flight: the law) flies back and rests
  std::vector<double> position_m;    ///< forecast along the axis, positive with a positive stick
  std::vector<double> speed_m_s;
  double farthest_m = 0.0;
  double fastest_m_s = 0.0;
  double amplitude_counts = 0.0;        ///< of the largest movement, after adaptation to the fence
  double min_amplitude_counts = 660.0;  ///< of the smallest
  int in_parts = 0;                     ///< movements that are flown in parts, with a return between them
  int left_out = 0;                     ///< movements of the kind that do not fit at any useful amplitude
  std::size_t returns = 0;              ///< number of times that the pilot flies back to the start
};

/// The axis of this name: "roll", "pitch", "climb" or "yaw_rate".
const model::StickAxis& axis_of(const model::Vehicle& vehicle, const std::string& name);

/// Whether the manoeuvre must be aborted, because the aircraft would stop beyond the fence: |x| + v^2 / (2 a) > fence,
/// with the outward speed v.
bool must_abort(double position_m, double speed_m_s, const InputDesign& design);

/// Makes a sequence of movements, each from rest at the start. A movement fits if it stays inside the fence, including
/// the stopping distance, when InputDesign::disturbance acts to either side, the movement begins 0.2 m off the start,
/// and the axis responds a fifth more than in the vehicle file. A movement that does not fit is split, made smaller, or
/// left out.
/// @throws std::invalid_argument naming the invalid option, and if the fence is too small, one that is large enough.
Manoeuvre design_manoeuvre(const InputDesign& design, const model::StickAxis& axis);

/// Forecast of the significance of an effect of medium size (model::Typical). sigma: norm of its signature (change of
/// the response) without what the always fitted gain, frequency, damping and delay imitate, over the noise of the air.
/// nearest: the effect with the most similar signature. apart_sigma: the part of sigma that `nearest` cannot imitate.
struct Forecast {
  std::string effect;
  double size = 0.0;
  double sigma = 0.0;
  std::string nearest;
  double cosine = 0.0;  ///< |cosine| between the two signatures
  double apart_sigma = 0.0;
};

/// Smallest sigma and apart_sigma with which an effect can be named.
inline constexpr double kMinSigma = 5.0;

}  // namespace m100::lab::excite
