// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_family.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/model/axis/axis_structure.h"
#include "host_tests/lab/identify/model/levenberg_marquardt.h"

namespace m100::lab::identify {
namespace {

using model::AxisEffect;
using model::AxisNumber;
using model::StickAxis;
using Parameters = std::vector<AxisParameter>;

/// The cost by which fits are compared. A variant, such as a jump at the dead zone's edge, has a penalty of 2 %: in a
/// log whose sticks never rest near the dead zone, a jump of any width fits.
double cost(const Fit& fit) { return fit.shape.empty() ? fit.sum_of_squares : 1.02 * fit.sum_of_squares; }

/// The fit with the lower cost.
Fit cheaper(Fit one, Fit other) { return cost(one) < cost(other) ? std::move(one) : std::move(other); }

bool has_token(const std::string& shape, std::string_view token) { return shape.find(token) != std::string::npos; }

std::vector<std::string_view> variants_of(const AxisEffect& effect) {
  return effect.variant.empty() ? std::vector<std::string_view>{""} : std::vector<std::string_view>{"", effect.variant};
}

/// The parameters of an earlier fit, if there was one.
class WarmStart {
 public:
  explicit WarmStart(const Fit* fit)
      : fit_(fit), parameters_(parameters_of(fit != nullptr ? fit->structure : Structure{})) {}

  bool has(const std::string& effect) const { return fit_ != nullptr && identify::has(fit_->structure, effect); }

  /// The parameter's value in the earlier fit or, if that fit does not have it, `start` as a fitted number.
  double or_start(const AxisParameter& parameter, double start) const {
    double value = to_fitted(*parameter.number, start);
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      if (parameters_[k].is(parameter.number->member)) {
        value = fit_->parameters[k];
      }
    }
    return value;
  }

  /// The variants of the structure's effects in the earlier fit.
  std::string shape_in(const Structure& structure) const {
    std::string out;
    for (const AxisEffect& effect : model::kAxisEffects) {
      const bool found = fit_ != nullptr && !effect.variant.empty() && has_token(fit_->shape, effect.variant);
      if (found && identify::has(structure, effect.name)) {
        out += effect.variant;
      }
    }
    return out;
  }

 private:
  const Fit* fit_;
  Parameters parameters_;
};

/// The start with the parameters of one more effect: the known ones, and the others from a row of the effect's starts.
Fit begun_with(Fit start, const AxisEffect& effect, const std::array<double, 3>& row, const Parameters& parameters,
               const WarmStart& known) {
  const bool is_known = known.has(std::string(effect.name));
  std::size_t column = 0;
  for (const AxisParameter& p : parameters) {
    if (p.effect != &effect) {
      continue;
    }
    // The gain is the same quantity in both orders, so it is taken from the earlier fit although the order is new.
    const bool is_same = is_known || p.is(&StickAxis::scale_per_count);
    start.parameters.push_back(is_same ? known.or_start(p, row[column]) : to_fitted(*p.number, row[column]));
    ++column;
  }
  return start;
}

/// A fit with one effect reset to a row of its starts; the gain is kept.
Fit thrown_back(Fit fit, const AxisEffect& effect, const std::array<double, 3>& row, const Parameters& parameters) {
  std::size_t column = 0;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].effect != &effect) {
      continue;
    }
    if (!parameters[k].is(&StickAxis::scale_per_count)) {
      fit.parameters[k] = to_fitted(*parameters[k].number, row[column]);
    }
    ++column;
  }
  return fit;
}

}  // namespace

AxisFamily::AxisFamily(const AxisBlocks& training) : training_(training), scale_(scale_of(training)) {}

bool AxisFamily::supports(const std::string& name) { return model::axis_effect(name) != nullptr; }

std::vector<AxisFamily::ParameterName> AxisFamily::parameter_names(const Structure& structure) const {
  std::vector<ParameterName> out;
  for (const AxisParameter& parameter : parameters_of(structure)) {
    out.push_back({std::string(parameter.effect->name), std::string(parameter.number->parameter)});
  }
  return out;
}

double AxisFamily::physical(const Fit& fit, std::size_t parameter) const {
  const AxisNumber& number = *parameters_of(fit.structure)[parameter].number;
  return scale_.physical(number, from_fitted(number, fit.parameters[parameter]));
}

StickAxis AxisFamily::model(const Fit& fit) const {
  StickAxis axis;
  const Parameters parameters = parameters_of(fit.structure);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const AxisNumber& number = *parameters[i].number;
    axis.*number.member = scale_.physical(number, from_fitted(number, fit.parameters[i]));
  }
  if (has_token(fit.shape, "jump")) {
    axis.dead_zone_shape = model::DeadZoneShape::kJump;
  }
  if (has_token(fit.shape, "slew")) {
    axis.command_slew_per_s = axis.rate_limit_per_s;
    axis.rate_limit_per_s = 0.0;
  }
  return axis;
}

std::size_t AxisFamily::samples_of(std::span<const int> weights) const {
  std::size_t samples = 0;
  for (std::size_t block = 0; block < training_.size(); ++block) {
    samples += weights[block] > 0 ? samples_in(block) : 0;
  }
  return samples;
}

Fit AxisFamily::run(Fit start, std::span<const int> weights, int iterations) const {
  const Parameters parameters = parameters_of(start.structure);
  std::vector<Box> box;
  for (const AxisParameter& p : parameters) {
    box.push_back({to_fitted(*p.number, p.number->fit.low), to_fitted(*p.number, p.number->fit.high), p.number->step});
  }
  const std::size_t rows = samples_of(weights);
  std::vector<double> scratch((parameters.size() + 2) * rows);
  std::vector<double> x = start.parameters;
  const auto residual = [&](std::span<const double> at, std::span<double> out) {
    start.parameters.assign(at.begin(), at.end());
    training_.error(model(start), weights, out);
  };
  start.sum_of_squares = levenberg_marquardt(residual, std::span<double>(x), box, rows, scratch, {iterations, 1e-4});
  start.parameters = x;
  start.free_parameters = parameters.size();
  return start;
}

double AxisFamily::sum_of_squares(const Fit& fit, std::span<const int> weights) const {
  const std::size_t rows = samples_of(weights);
  std::vector<double> out(rows);
  training_.error(model(fit), weights, out);
  return std::inner_product(out.begin(), out.end(), out.begin(), 0.0);
}

Fit AxisFamily::with_jump(Fit fit, std::span<const int> weights) const {
  constexpr double kWidest = 0.6;
  constexpr double kStep = 0.02;
  constexpr double kFineStep = 0.002;
  const Parameters parameters = parameters_of(fit.structure);
  const auto width = std::find_if(parameters.begin(), parameters.end(),
                                  [](const AxisParameter& p) { return p.is(&StickAxis::dead_zone_counts); });
  const auto at = static_cast<std::size_t>(width - parameters.begin());
  fit.shape += has_token(fit.shape, "jump") ? "" : "jump";
  const auto scan = [&](double from, double to, double step) {
    Fit best = fit;
    best.sum_of_squares = 0.0;
    for (double value = from; value <= to; value += step) {
      fit.parameters[at] = to_fitted(*width->number, value);
      fit.sum_of_squares = sum_of_squares(fit, weights);
      best = best.sum_of_squares > 0.0 && best.sum_of_squares <= fit.sum_of_squares ? best : fit;
    }
    return best;
  };
  fit = run(scan(kStep, kWidest, kStep), weights, 10);
  const double found = from_fitted(*width->number, fit.parameters[at]);
  return run(scan(std::max(kFineStep, found - kStep), found + kStep, kFineStep), weights, 15);
}

Fit AxisFamily::polish(const Fit& fit, std::span<const int> weights) const {
  Fit best = run(fit, weights, 15);
  if (has(fit.structure, "dead_zone")) {
    best = cheaper(with_jump(best, weights), best);
  }
  const Parameters parameters = parameters_of(fit.structure);
  for (const std::string& name : fit.structure) {
    const AxisEffect& effect = *model::axis_effect(name);
    for (const std::string_view variant : variants_of(effect)) {
      for (const std::array<double, 3>& row : effect.starts) {
        Fit start = thrown_back(best, effect, row, parameters);
        start.shape = without_token(start.shape, effect.variant) + std::string(variant);
        const Fit tried = run(std::move(start), weights, 5);
        if (tried.sum_of_squares < 1.05 * best.sum_of_squares) {
          best = cheaper(run(tried, weights, 15), best);
        }
      }
    }
  }
  return best;
}

Fit AxisFamily::fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const {
  if (warm != nullptr && warm->structure == structure) {
    Fit same = *warm;
    same.sum_of_squares = 0.0;
    same.free_parameters = 0;
    return run(std::move(same), weights, 6);
  }
  Fit best = run(best_of(starts_of(structure, warm), weights), weights, 25);
  if (has(structure, "dead_zone") && (warm == nullptr || !has(warm->structure, "dead_zone"))) {
    return cheaper(with_jump(best, weights), best);
  }
  return best;
}

Fit AxisFamily::best_of(std::vector<Fit> starts, std::span<const int> weights) const {
  constexpr std::size_t kMany = 12;
  constexpr std::size_t kKept = 4;  // one in four continues
  constexpr int kFirst = 2;
  constexpr int kAll = 5;
  if (starts.size() == 1) {
    return starts.front();
  }
  const bool many = starts.size() > kMany;
  for (Fit& start : starts) {
    start = run(std::move(start), weights, many ? kFirst : kAll);
  }
  const auto costs_less = [](const Fit& a, const Fit& b) { return cost(a) < cost(b); };
  if (many) {
    std::stable_sort(starts.begin(), starts.end(), costs_less);
    starts.resize(starts.size() / kKept);
    for (Fit& start : starts) {
      start = run(std::move(start), weights, kAll - kFirst);
    }
  }
  return *std::min_element(starts.begin(), starts.end(), costs_less);
}

std::vector<Fit> AxisFamily::starts_of(const Structure& structure, const Fit* warm) {
  const WarmStart known(warm);
  const Parameters parameters = parameters_of(structure);
  std::vector<Fit> starts(1);
  starts[0].structure = structure;
  starts[0].shape = known.shape_in(structure);
  for (const std::string& name : structure) {
    const AxisEffect& effect = *model::axis_effect(name);
    const bool is_known = known.has(name);
    const std::vector<std::string_view> variants = is_known ? std::vector<std::string_view>{""} : variants_of(effect);
    const auto rows = std::span(effect.starts).first(is_known ? 1 : effect.starts.size());
    std::vector<Fit> extended;
    for (const Fit& start : starts) {
      for (const std::string_view variant : variants) {
        for (const std::array<double, 3>& row : rows) {
          extended.push_back(begun_with(start, effect, row, parameters, known));
          extended.back().shape += variant;
        }
      }
    }
    starts = std::move(extended);
  }
  return starts;
}

Fit AxisFamily::with_parameters_of(Fit like, const StickAxis& axis) const {
  const Parameters parameters = parameters_of(like.structure);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const AxisNumber& number = *parameters[k].number;
    const bool slews = number.member == &StickAxis::rate_limit_per_s && has_token(like.shape, "slew");
    const double value = slews ? axis.command_slew_per_s : axis.*number.member;
    like.parameters[k] = to_fitted(number, std::clamp(scale_.in_unit(number, value), number.fit.low, number.fit.high));
  }
  return like;
}

std::vector<Fit> AxisFamily::starts_with_effect(const Edit& edit, const Fit& known) const {
  std::vector<Fit> out = starts_of(edit.structure, &known);
  const Parameters parameters = parameters_of(edit.structure);
  for (Fit& start : out) {
    start.sum_of_squares = known.sum_of_squares;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const AxisNumber& number = *parameters[k].number;
      if (parameters[k].effect->name != edit.name || number.min_relevant <= 0.0 ||
          from_fitted(number, start.parameters[k]) != number.neutral) {
        continue;
      }
      const bool counts = number.unit == AxisNumber::FitUnit::kStick;
      const double least = counts ? number.min_relevant * scale_.minimum_counts / scale_.stick : number.min_relevant;
      start.parameters[k] = to_fitted(number, number.neutral) + least;
    }
  }
  return out;
}

std::vector<Fit> AxisFamily::variants(const Fit& fit) const {
  const std::vector<int> all(training_.size(), 1);
  if (!has(fit.structure, "dead_zone")) {
    return {};
  }
  if (!has_token(fit.shape, "jump")) {
    return {with_jump(fit, all)};
  }
  Fit plain = fit;
  plain.shape = without_token(fit.shape, "jump");
  return {run(std::move(plain), all, 15)};
}

std::vector<std::vector<double>> AxisFamily::errors(const Fit& fit, std::span<const int> weights) const {
  std::vector<double> flat(training_.samples());
  std::vector<int> ones(weights.size());
  std::transform(weights.begin(), weights.end(), ones.begin(), [](int weight) { return weight > 0 ? 1 : 0; });
  training_.error(model(fit), ones, flat);
  std::vector<std::vector<double>> out(training_.size());
  auto at = flat.begin();
  for (std::size_t block = 0; block < out.size(); ++block) {
    if (ones[block] > 0) {
      const auto next = at + static_cast<std::ptrdiff_t>(samples_in(block));
      out[block].assign(at, next);
      at = next;
    }
  }
  return out;
}

std::vector<Family::Edit> AxisFamily::edits(const Structure& present) const {
  return axis_edits(present, !training_.data().other.empty());
}

Structure AxisFamily::completed(const Structure& declared) const {
  Structure out = declared;
  for (const AxisEffect& effect : model::kAxisEffects) {
    if (effect.in_every_model && !has(out, effect.name)) {
      out.emplace_back(effect.name);
    }
  }
  return out;
}

Structure AxisFamily::without(const Structure& structure, const std::string& name) const {
  return without_effect(structure, name);
}

Fit AxisFamily::switched_off(const Fit& fit, const std::string& name) const {
  const Structure reduced = without(fit.structure, name);
  if (reduced.front() != fit.structure.front()) {
    return Family::switched_off(fit, name);
  }
  return with_parameters_of({reduced, std::vector<double>(parameters_of(reduced).size()), fit.shape}, model(fit));
}

bool AxisFamily::is_significant(const Fit& fit, const std::string& name) const {
  const Parameters parameters = parameters_of(fit.structure);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (name == parameters[i].effect->name && !is_parameter_significant(fit, i, *parameters[i].number)) {
      return false;
    }
  }
  return true;
}

std::vector<std::size_t> AxisFamily::parameters_at_bound(const Fit& fit) const {
  const Parameters parameters = parameters_of(fit.structure);
  std::vector<std::size_t> out(parameters.size());
  std::iota(out.begin(), out.end(), 0U);
  std::erase_if(out, [&](std::size_t i) { return !identify::is_at_bound(*parameters[i].number, fit.parameters[i]); });
  return out;
}

bool AxisFamily::is_parameter_significant(const Fit& fit, std::size_t parameter, const AxisNumber& number) const {
  // An effect whose fit ends at the edge of its physical range explains something else.
  if (identify::is_at_bound(number, fit.parameters[parameter])) {
    return false;
  }
  if (number.min_relevant <= 0.0) {
    return true;
  }
  const double value = physical(fit, parameter);
  const double distance =
      number.logarithmic ? std::abs(std::log(value / number.neutral)) : std::abs(value - number.neutral);
  const double least =
      number.unit == AxisNumber::FitUnit::kStick ? number.min_relevant * scale_.minimum_counts : number.min_relevant;
  return distance >= least;
}

}  // namespace m100::lab::identify
