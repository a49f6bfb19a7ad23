// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/excite/manoeuvre.h"

namespace m100::lab::excite {

/// The significance of each candidate effect, by Fisher information. For independent noise of standard deviation s, the
/// information on the size of an effect is |signature|^2 / s^2; the signature is its change of the response. Effects
/// that need the other stick are left out for a rate axis.
std::vector<Forecast> forecast(const Manoeuvre& manoeuvre, const model::StickAxis& axis,
                               const InputDesign& design = {});
/// The response of the axis to the stick with one added effect, without air; for forecast() and its test. `size` is the
/// effect's first number; an empty name stands for no effect.
std::vector<double> response(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const InputDesign& design,
                             const std::string& effect, double size);
/// The other stick during response() [counts]: a pilot's small corrections, without which no coupling could show.
double other_stick(double t_s);

}  // namespace m100::lab::excite
