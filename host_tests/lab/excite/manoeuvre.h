// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "firmware/model/vehicle.h"

namespace m100::lab::excite {

// Stick movements that make the candidates of a residual tell themselves apart, and a forecast of how well they will.

/// What is wanted. Amplitudes in counts, lengths in m from where the manoeuvre begins.
struct Wish {
  std::string axis = "roll";   ///< "roll" or "pitch"; "climb" or "yaw_rate", see `rate`
  std::string kind = "mixed";  ///< "doublet", "3211", "chirp" or "mixed"
  double amplitude_counts = 200.0;
  double duration_s = 40.0;
  double fence_m = 8.0;
  double brake_m_s2 = 2.0;  ///< what the abort counts on
  /// The response is a speed (climb [m/s], yaw rate [rad/s]) and its integral is what the fence is about: height [m] or
  /// heading [rad]. Otherwise it is a tilt, and the vehicle runs away with its tangent.
  bool rate = false;
  /// What pushes along the axis though nobody foresees it, all the time: 0.3 m/s^2 is a balancing point that is 30
  /// counts off, or a wind of the class of 3 m/s that rises by a third of its speed at a drag of 0.3 1/s. Of a rate
  /// axis a speed [m/s, rad/s].
  double push = 0.3;
  double air = 0.0045;  ///< root mean square of the response with a resting stick, in its unit; memory 0.3 s
};

struct Manoeuvre {
  double period_s = 0.02;
  std::vector<double> stick_counts;  ///< from neutral
  std::vector<int> piece;            ///< from 1 on; 0 where the pilot (in flight: the law) flies back and rests
  std::vector<double> position_m;    ///< forecast along the axis, positive as the stick pushes
  std::vector<double> speed_m_s;
  double farthest_m = 0.0;
  double fastest_m_s = 0.0;
  double amplitude_counts = 0.0;          ///< of the largest movement, after it was made to fit into the fence
  double least_amplitude_counts = 660.0;  ///< of the smallest
  int in_parts = 0;                       ///< movements that are flown in parts, with a return between them
  int left_out = 0;         ///< movements of the kind that do not fit at any amplitude that shows something
  std::size_t returns = 0;  ///< stretches in which the pilot flies back to the middle
};

/// Leave the manoeuvre when the way to stop would end beyond the fence: |x| + v^2 / (2 a) > fence, v outwards.
bool must_abort(double position_m, double speed_m_s, const Wish& wish);

/// Strings movements together, each from rest at the place. A movement fits if it keeps within the fence, way to stop
/// included, though Wish::push acts on it to either side, it begins 0.2 m off the place and the axis answers a fifth
/// more than the vehicle file says; what does not is flown in parts, or smaller, or left out.
/// @throws std::invalid_argument naming the field that makes no sense, and the fence that would be enough.
Manoeuvre make(const Wish& wish, const model::StickAxis& axis);

/// How an effect of medium size will show: sigma is the length of its signature after the parameters that are fitted
/// anyway (gain, frequency, damping, delay) have taken their share, over the coloured noise of the air; the nearest
/// rival is the candidate whose signature is most alike, apart_sigma what remains of the first beside any amount of it.
struct Forecast {
  std::string effect;
  double size = 0.0;
  double sigma = 0.0;
  std::string nearest;
  double likeness = 0.0;  ///< |cosine| between the two signatures
  double apart_sigma = 0.0;
};

/// Fisher information with the signatures as derivatives: for independent noise of spread s, the information on the
/// size of an effect is |signature|^2 / s^2. The air's noise is counted by its number of independent samples. A rate
/// axis has no other stick: no cross_axis.
std::vector<Forecast> forecast(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const Wish& wish = {});

/// What the stick would make of the axis with one effect more, without air: forecast() and its test look at it. `size`
/// is the effect's first number; an empty name stands for no effect.
std::vector<double> response(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const Wish& wish,
                             const std::string& effect, double size);
/// The other stick during response(): the small corrections of a pilot. Without them no coupling could show.
double other_stick(double t_s);

/// Enough for a name: this many sigma for the effect and beside its nearest rival.
inline constexpr double kEnough_sigma = 5.0;

}  // namespace m100::lab::excite
