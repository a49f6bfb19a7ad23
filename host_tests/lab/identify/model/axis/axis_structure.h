// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/selection/selection.h"

namespace m100::lab::identify {

// The parameters of a structure of a stick axis (base model, then effects), and its possible edits. Everything is read
// from model::kAxisEffects.

/// One free parameter of a structure.
struct AxisParameter {
  const model::AxisEffect* effect;
  const model::AxisNumber* number;
  bool is(double model::StickAxis::*member) const { return number->member == member; }
};

/// The free parameters in the order of the structure's effects. A number that two effects share is free only once: the
/// delay of a lead zero is the transport delay, if the structure has one. Precondition: every name of the structure is
/// an effect of the table.
std::vector<AxisParameter> parameters_of(const Structure& structure);

/// Converts a number in the parameter's unit to the fitted number, and back.
double to_fitted(const model::AxisNumber& number, double in_unit);
double from_fitted(const model::AxisNumber& number, double fitted);
/// Whether a fitted number is at the edge of its physical range; zero is no edge.
bool is_at_bound(const model::AxisNumber& number, double fitted);

/// The structures with one more effect, or with a more complex base model.
/// @param has_other  whether the log holds the other axis' stick
std::vector<Family::Edit> axis_edits(const Structure& present, bool has_other);

/// The structure without this effect. A base model becomes the first order, unless an effect needs that base model.
Structure without_effect(const Structure& structure, std::string_view name);

/// Removes the letters of `token` from a fit's shape, which lists the variants of its effects one after another.
std::string without_token(std::string shape, std::string_view token);

}  // namespace m100::lab::identify
