// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/translation_family.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host_tests/lab/identify/model/translation/coordinate_search.h"
#include "host_tests/lab/identify/residual_tests/translation/periodic_force_check.h"

namespace m100::lab::identify {

using namespace translation;  // its own parts
using model::SearchedParameter;
using model::TranslationEffect;

namespace {

constexpr double kAliasShare = 0.97;

/// Least squares with a small ridge, because the log may not excite every column.
Vector least_squares(const Matrix& columns, const Vector& target) {
  Matrix normal = columns.transpose() * columns;
  normal.diagonal().array() += 1e-9 * normal.trace() + 1e-12;
  return normal.ldlt().solve(columns.transpose() * target);
}

/// The acceleration that the wind causes on a vehicle at rest, by every drag of the fit.
model::Acceleration wind_at_rest(const Fit& fit) {
  const std::array<double, 3> wind = wind_of(searched_of(fit));
  const model::Moment rest{.air_velocity_w_m_s = {-wind[0], -wind[1], -wind[2]}};
  model::Acceleration sum{};
  for (const std::string& name : fit.structure) {
    const TranslationEffect* effect = model::translation_effect(name);
    if (effect == nullptr || effect->drag == model::Drag::kNone) {
      continue;
    }
    const std::span<const double> linear = linear_of(fit, name);
    for (std::size_t k = 0; k < linear.size(); ++k) {
      const model::Acceleration column = effect->column(k, rest, 0.0);
      for (std::size_t c = 0; c < sum.size(); ++c) {
        sum[c] += linear[k] * column[c];
      }
    }
  }
  return sum;
}

/// Whether an earlier fit has the slot's parameter.
bool was_found(const Slot& slot, const Fit* warm) {
  if (warm == nullptr) {
    return false;
  }
  return slot.parameter().start == model::Start::kWindSpeed ? is_wind_speed_searched(warm->structure)
                                                            : has(warm->structure, slot.effect->name);
}

/// Combines every start with every value of one parameter.
std::vector<SearchPoint> spread(const std::vector<SearchPoint>& starts, std::size_t slot,
                                std::span<const double> values) {
  std::vector<SearchPoint> out;
  for (const SearchPoint& start : starts) {
    for (const double value : values) {
      out.push_back(start);
      out.back()[slot] = value;
    }
  }
  return out;
}

}  // namespace

TranslationFamily::TranslationFamily(const TranslationBlocks& training) : training_(training) {}

bool TranslationFamily::supports(const std::string& name) {
  return name == "rigid_body" || model::translation_effect(name) != nullptr;
}

bool TranslationFamily::is_observable(const std::string& name) const {
  const TranslationEffect* effect = model::translation_effect(name);
  if (effect == nullptr) {
    return true;  // rigid_body
  }
  const TranslationData& data = *training_.data;
  if (training_.head != nullptr && effect->searched_count() > 0 &&
      effect->searched[0].start == model::Start::kWindSpeed) {
    return false;  // each flight's wind is estimated at its start
  }
  return data.has_signals_for(effect->needs);
}

Fit TranslationFamily::fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const {
  const Vector y = measured_rows(training_);
  const CoordinateSearch search(training_, y, structure, weights, normals_);
  const std::array<bool, kSearched> used = searched_in(structure);
  SearchPoint at{};
  for (std::size_t k = 0; k < kSearched; ++k) {
    at[k] = warm != nullptr && used[k] ? warm->parameters[k] : 0.0;
  }
  if (search.has_parameters() && warm != nullptr && warm->structure == structure) {
    search.refine(at, &SearchedParameter::repeated_step, 8);
  } else if (search.has_parameters()) {
    Starts from = starts(structure, weights, warm, at);
    double best = 0.0;
    for (std::size_t s = 0; s < from.size(); ++s) {
      search.refine(from[s], &SearchedParameter::first_step, 4);
      const double value = search.cost(from[s]);
      if (s == 0 || value < best) {
        best = value;
        at = from[s];
      }
    }
    search.refine(at, &SearchedParameter::last_step, 12);
  }
  const Solution solution = solve(training_, y, structure, at, weights, normals_);
  Fit out;
  out.structure = structure;
  out.parameters.assign(at.begin(), at.end());
  out.parameters.insert(out.parameters.end(), solution.linear.begin(), solution.linear.end());
  out.parameters.insert(out.parameters.end(), solution.winds.begin(), solution.winds.end());
  out.sum_of_squares = solution.sum_of_squares;
  out.free_parameters = linear_count(structure) + static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
  out.free_parameters += solution.winds.empty() ? 0 : solution.winds.size() - 2;  // about their mean
  return out;
}

TranslationFamily::Starts TranslationFamily::starts(const Structure& structure, std::span<const int> weights,
                                                    const Fit* warm, const SearchPoint& common) const {
  Starts out{common};
  const std::array<bool, kSearched> used = searched_in(structure);
  for (std::size_t k = 0; k < kSearched; ++k) {
    const Slot& slot = slots()[k];
    const SearchedParameter& parameter = slot.parameter();
    if (!used[k] || was_found(slot, warm)) {
      continue;
    }
    if (parameter.start == model::Start::kWindSpeed) {
      out = slot.which == 0 ? wind_starts(out, structure, weights) : out;
    } else if (parameter.start == model::Start::kStrongestPeak) {
      const Fit plain = fit(without(structure, std::string(slot.effect->name)), weights, warm);
      const Vector left = residual_of(training_, measured_rows(training_), plain);
      out = spread(out, k, std::array{strongest_peak_hz(training_, left, weights)});
    } else {
      out = spread(out, k, std::span(parameter.values).first(parameter.value_count));
    }
  }
  return out;
}

TranslationFamily::Starts TranslationFamily::wind_starts(const Starts& starts, const Structure& structure,
                                                         std::span<const int> weights) const {
  Structure plain;
  std::string wind_name;
  for (const std::string& name : structure) {
    const TranslationEffect* effect = model::translation_effect(name);
    const bool searched = effect != nullptr && effect->searched_count() > 0;
    const bool is_wind = searched && effect->searched[0].start == model::Start::kWindSpeed;
    wind_name = is_wind ? name : wind_name;
    if (effect == nullptr || is_wind || (!searched && effect->drag != model::Drag::kProgressive)) {
      plain.push_back(name);
    }
  }
  const Fit wind = fit(plain, weights, nullptr);
  const std::span<const double> acceleration = linear_of(wind, wind_name);
  const double size = std::max(1e-3, std::hypot(acceleration[0], acceleration[1]));
  Starts out;
  for (const SearchPoint& start : starts) {
    for (const double coefficient_per_m : {0.02, 0.08, 0.25}) {
      out.push_back(start);
      const double speed = std::sqrt(size / coefficient_per_m);
      const std::size_t first = slot_of(*model::translation_effect(wind_name));
      for (std::size_t c = 0; c < 2; ++c) {
        out.back()[first + c] = acceleration[c] / size * speed;
      }
    }
  }
  return out;
}

std::vector<std::vector<double>> TranslationFamily::errors(const Fit& fit, std::span<const int> weights) const {
  const Vector residual = residual_of(training_, measured_rows(training_), fit);
  std::vector<std::vector<double>> out(block_count());
  for (std::size_t b = 0; b < out.size(); ++b) {
    if (weights[b] > 0) {
      const double* begin = residual.data() + training_.blocks[b].row;
      out[b].assign(begin, begin + samples_in(b));
    }
  }
  return out;
}

std::vector<Family::Edit> TranslationFamily::edits(const Structure& present) const {
  std::vector<Edit> out;
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    const std::string name(effect.name);
    if (!has(present, name) && is_observable(name)) {
      Structure more = present;
      more.push_back(name);
      out.push_back({name, more});
    }
  }
  return out;
}

Structure TranslationFamily::without(const Structure& structure, const std::string& name) const {
  Structure out;
  std::copy_if(structure.begin(), structure.end(), std::back_inserter(out),
               [&](const std::string& one) { return one != name || one == "rigid_body"; });
  return out;
}

std::vector<NamedValue> TranslationFamily::parameters(const Fit& fit, const std::string& name) {
  const TranslationEffect* effect = model::translation_effect(name);
  if (effect == nullptr) {
    return {};
  }
  const model::Acceleration wind = wind_at_rest(fit);
  const bool by_speed = effect->columns > 0 && linear_count(fit.structure, name) == 0;
  const std::span<const double> linear = by_speed ? std::span<const double>(wind) : linear_of(fit, name);
  std::vector<double> values(effect->parameter_count());
  if (effect->report != nullptr) {
    const auto first = effect->searched_count() > 0 ? slot_of(*effect) : 0;
    effect->report(std::span(fit.parameters).subspan(first, effect->searched_count()), linear, values);
  } else {
    std::copy_n(linear.begin(), values.size(), values.begin());
  }
  std::vector<NamedValue> out;
  for (std::size_t k = 0; k < values.size(); ++k) {
    out.push_back({std::string(effect->parameters[k].name), values[k]});
  }
  return out;
}

bool TranslationFamily::is_significant(const Fit& fit, const std::string& name) const {
  const TranslationEffect* effect = model::translation_effect(name);
  if (effect == nullptr) {
    return false;
  }
  std::vector<double> values;
  for (const NamedValue& one : parameters(fit, name)) {
    const model::EffectParameter& parameter = effect->parameters[values.size()];
    if (!(one.value >= parameter.low && one.value <= parameter.high)) {
      return false;
    }
    values.push_back(one.value);
  }
  return effect->size(values) >= effect->min_relevant &&
         (!effect->is_periodic || is_periodic_force(*this, training_, fit, *effect));
}

bool TranslationFamily::alias(const Fit& winner, const std::string& name, const std::string& rival) const {
  const TranslationEffect* other_effect = model::translation_effect(rival);
  if (other_effect == nullptr || !is_observable(rival) || linear_count(winner.structure, name) == 0 ||
      has(winner.structure, rival) || other_effect->columns == 0 || other_effect->is_periodic) {
    return false;
  }
  const SearchPoint searched = searched_of(winner);
  const Regression own(training_, winner.structure, searched);
  const std::span<const double> linear = linear_of(winner, name);
  const auto first = static_cast<Eigen::Index>(column_of(winner.structure, name));
  const auto count = static_cast<Eigen::Index>(linear.size());
  const Vector acts = own.columns.middleCols(first, count) * Eigen::Map<const Vector>(linear.data(), count);
  const Regression other(training_, {"rigid_body", rival}, searched);
  const Vector fitted = other.columns * least_squares(other.columns, acts);
  return acts.squaredNorm() > 0.0 && (acts - fitted).squaredNorm() < (1.0 - kAliasShare) * acts.squaredNorm();
}

double TranslationFamily::preference(const TranslationBlocks& present, const TranslationBlocks& other) {
  Structure structure{"rigid_body", "steady_wind", "body_bias", "tilt_gain"};
  if (present.data->has_velocity) {
    structure.emplace_back("linear_drag");
  }
  const std::string line = "periodic_wind";
  const Vector y = measured_rows(present);
  SearchPoint searched{};
  double coefficient = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    if (pass == 1) {
      structure.push_back(line);
    }
    const Regression model(present, structure, searched);
    const Vector difference = Regression(other, {"rigid_body"}, SearchPoint{}).base - model.base;
    Matrix columns(model.columns.rows(), model.columns.cols() + 1);
    columns << model.columns, difference;
    const Vector target = y - model.base;
    const Vector solution = least_squares(columns, target);
    coefficient = solution(solution.size() - 1);
    const Vector left = target - columns * solution;
    searched[slot_of(*model::translation_effect(line))] = strongest_peak_hz(present, left, {});
  }
  return coefficient;
}

std::vector<double> TranslationFamily::measured(const TranslationBlocks& part) {
  const Vector y = measured_rows(part);
  return {y.begin(), y.end()};
}

std::vector<double> TranslationFamily::prediction(const TranslationBlocks& part, const Fit& fit) {
  const Vector y = measured_rows(part);
  const Vector predicted = y - residual_of(part, y, fit);
  return {predicted.begin(), predicted.end()};
}

}  // namespace m100::lab::identify
