// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_structure.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {

using model::AxisEffect;
using model::AxisNumber;

std::vector<AxisParameter> parameters_of(const Structure& structure) {
  std::vector<AxisParameter> out;
  for (const std::string& name : structure) {
    const AxisEffect& effect = *model::axis_effect(name);
    for (const AxisNumber& number : effect.numbers) {
      const bool twice = std::any_of(structure.begin(), structure.end(), [&](const std::string& other) {
        return other != name && model::axis_effect(other)->numbers[0].member == number.member;
      });
      if (!twice) {
        out.push_back({&effect, &number});
      }
    }
  }
  return out;
}

double to_fitted(const AxisNumber& number, double in_unit) { return number.logarithmic ? std::log(in_unit) : in_unit; }
double from_fitted(const AxisNumber& number, double fitted) { return number.logarithmic ? std::exp(fitted) : fitted; }

std::vector<Family::Edit> axis_edits(const Structure& present, bool has_other) {
  std::vector<Family::Edit> out;
  const auto contained = [&](const AxisEffect& effect) {
    return !effect.not_beside.empty() && has(present, effect.not_beside);
  };
  for (const AxisEffect& effect : model::kAxisEffects) {
    const bool simplest = &effect == &model::kAxisEffects.front();  // no edit makes a structure simpler
    const bool possible =
        (has_other || !effect.needs_other_stick) && (effect.needs.empty() || has(present, effect.needs));
    if (simplest || !possible || contained(effect) || has(present, effect.name)) {
      continue;
    }
    Structure next = present;
    if (model::is_base(effect)) {
      next[0] = effect.name;
    } else {
      next.emplace_back(effect.name);
    }
    out.push_back({std::string(effect.name), std::move(next)});
  }
  return out;
}

Structure without_effect(const Structure& structure, std::string_view name) {
  Structure out = structure;
  if (model::is_base(*model::axis_effect(name))) {
    const bool needed = std::any_of(structure.begin(), structure.end(),
                                    [&](const std::string& other) { return model::axis_effect(other)->needs == name; });
    if (!needed) {
      out[0] = model::kAxisEffects.front().name;
    }
    return out;
  }
  out.erase(std::remove(out.begin() + 1, out.end(), name), out.end());
  return out;
}

std::string without_token(std::string shape, std::string_view token) {
  const std::size_t found = token.empty() ? std::string::npos : shape.find(token);
  if (found != std::string::npos) {
    shape.erase(found, token.size());
  }
  return shape;
}

bool is_at_bound(const model::AxisNumber& number, double fitted) {
  const double in_unit = from_fitted(number, fitted);
  const double margin = 1e-3 * (number.fit.high - number.fit.low);
  return in_unit > number.fit.high - margin || (number.fit.low != 0.0 && in_unit < number.fit.low + margin);
}

}  // namespace m100::lab::identify
