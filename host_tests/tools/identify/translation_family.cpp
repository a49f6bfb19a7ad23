// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/translation_family.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "host_tests/tools/identify/translation_search.h"

namespace m100::tools::identify {

using namespace translation;  // its own parts

namespace {

constexpr double kAliasShare = 0.97;
constexpr double kForetoldShare = 0.5;

}  // namespace

TranslationFamily::TranslationFamily(const TranslationBlocks& training) : training_(training) {}

bool TranslationFamily::knows(const std::string& name) { return name == "rigid_body" || effect_named(name) != nullptr; }

bool TranslationFamily::can_see(const std::string& name) const {
  const TranslationData& data = *training_.data;
  if (name == "linear_drag" || name == "quadratic_drag") {
    return data.has_velocity;
  }
  if (name == "thrust_gain" || name == "thrust_lag") {
    return data.has_thrust;
  }
  if (name == "axial_inflow") {
    return data.has_thrust && data.has_velocity;
  }
  // The accelerometer's horizontal axes read nothing of thrust, so its own tilt, heading and clock do not show there.
  if (name == "tilt_gain" || name == "yaw_misalignment" || name == "time_offset") {
    return data.source != "force";
  }
  return true;
}

Fit TranslationFamily::fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const {
  const Vector y = measured_rows(training_);
  const Search search(training_, y, structure, weights);
  std::array<double, kSearched> at{};
  if (warm != nullptr) {
    std::copy_n(warm->parameters.begin(), kSearched, at.begin());
  }
  const std::array<bool, kSearched> used = searched_in(structure);
  const bool same = warm != nullptr && warm->structure == structure;
  for (std::size_t k = 0; k < kSearched; ++k) {
    at[k] = used[k] ? at[k] : 0.0;
  }
  if (search.anything() && same) {
    search.refine(at, {0.005, 0.005, 0.002, 0.3, 0.3, 0.01}, 8);
  } else if (search.anything()) {
    const auto had = [&](const char* name) { return warm != nullptr && has(warm->structure, name); };
    std::vector<std::array<double, kSearched>> starts{at};
    const auto spread = [&](std::size_t k, const std::vector<double>& values) {
      std::vector<std::array<double, kSearched>> more;
      for (const auto& start : starts) {
        for (const double value : values) {
          more.push_back(start);
          more.back()[k] = value;
        }
      }
      starts = std::move(more);
    };
    if (used[0] && !had("thrust_lag")) {
      spread(0, {0.01, 0.04, 0.1, 0.2});
    }
    if (used[1] && !had("time_offset")) {
      spread(1, {-0.1, -0.03, 0.03, 0.1});
    }
    if (used[5] && !had("yaw_misalignment")) {
      spread(5, {-0.1, 0.1});
    }
    if (used[2] && !had("periodic_wind")) {
      Structure rest = structure;
      rest.erase(std::find(rest.begin(), rest.end(), "periodic_wind"));
      Fit plain = fit(rest, weights, warm);
      const Vector left = residual_of(training_, y, plain);
      spread(2, {strongest_line({axis_series(training_, left, 0, weights), axis_series(training_, left, 1, weights)})
                     .frequency_hz});
    }
    if (used[3] && !(had("steady_wind") && had("quadratic_drag"))) {
      starts = wind_starts(starts, structure, weights);
    }
    double best = 0.0;
    for (std::size_t s = 0; s < starts.size(); ++s) {
      search.refine(starts[s], {0.02, 0.02, 0.005, 1.0, 1.0, 0.05}, 4);
      const double value = search.cost(starts[s]);
      if (s == 0 || value < best) {
        best = value;
        at = starts[s];
      }
    }
    search.refine(at, {0.01, 0.01, 0.003, 0.5, 0.5, 0.02}, 12);
  }
  const Searched searched = as_searched(at);
  const Solution solution = solve(training_, y, structure, searched, weights);
  Fit out;
  out.structure = structure;
  out.parameters.assign(at.begin(), at.end());
  out.parameters.insert(out.parameters.end(), solution.linear.begin(), solution.linear.end());
  out.sum_of_squares = solution.sum_of_squares;
  out.free_parameters = linear_count(structure) + static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
  return out;
}

std::vector<std::array<double, TranslationFamily::kStartSize>> TranslationFamily::wind_starts(
    const std::vector<std::array<double, kStartSize>>& starts, const Structure& structure,
    std::span<const int> weights) const {
  static_assert(kStartSize == kSearched);
  Structure plain;
  for (const std::string& name : structure) {
    if (name != "quadratic_drag" && name != "thrust_lag" && name != "time_offset" && name != "periodic_wind" &&
        name != "yaw_misalignment") {
      plain.push_back(name);
    }
  }
  const Fit wind = fit(plain, weights, nullptr);
  const std::size_t column = kSearched + column_of(plain, "steady_wind");
  const double ax = wind.parameters[column];
  const double ay = wind.parameters[column + 1];
  const double size = std::max(1e-3, std::hypot(ax, ay));
  std::vector<std::array<double, kSearched>> out;
  for (const auto& start : starts) {
    for (const double coefficient_per_m : {0.02, 0.08, 0.25}) {
      out.push_back(start);
      const double speed = std::sqrt(size / coefficient_per_m);
      out.back()[3] = ax / size * speed;
      out.back()[4] = ay / size * speed;
    }
  }
  return out;
}

std::vector<double> TranslationFamily::error(const Fit& fit, std::size_t block) const {
  std::vector<int> weights(block_count(), 0);
  weights[block] = 1;
  return errors(fit, weights)[block];
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
  for (const Effect& effect : effects()) {
    if (!has(present, effect.name) && can_see(effect.name)) {
      Structure more = present;
      more.emplace_back(effect.name);
      out.push_back({effect.name, more});
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
  const Effect* effect = effect_named(name);
  if (effect == nullptr) {
    return {};
  }
  const Searched searched = as_searched(fit.parameters);
  const auto linear = [&](std::size_t k) { return fit.parameters[kSearched + column_of(fit.structure, name) + k]; };
  std::vector<double> values;
  if (name == "thrust_lag") {
    values = {searched.lag_s};
  } else if (name == "time_offset") {
    values = {searched.offset_s};
  } else if (name == "yaw_misalignment") {
    values = {searched.angle_rad};
  } else if (name == "tilt_gain" || name == "thrust_gain") {
    values = {1.0 + linear(0)};
  } else if (name == "periodic_wind") {
    values = {searched.frequency_hz, std::hypot(linear(0), linear(1)), std::hypot(linear(2), linear(3))};
  } else if (name == "steady_wind" && wind_speed_matters(fit.structure)) {
    const double speed = std::hypot(searched.wind_x_m_s, searched.wind_y_m_s);
    double per_s = speed * fit.parameters[kSearched + column_of(fit.structure, "quadratic_drag")];
    if (has(fit.structure, "linear_drag")) {
      per_s += fit.parameters[kSearched + column_of(fit.structure, "linear_drag")];
    }
    values = {per_s * searched.wind_x_m_s, per_s * searched.wind_y_m_s};
  } else {
    for (std::size_t k = 0; k < linear_count(fit.structure, name); ++k) {
      values.push_back(linear(k));
    }
  }
  std::vector<NamedValue> out;
  for (std::size_t k = 0; k < values.size(); ++k) {
    out.push_back({effect->parameters[k], values[k]});
  }
  return out;
}

bool TranslationFamily::big_enough(const Fit& fit, const std::string& name) const {
  const Effect* effect = effect_named(name);
  if (effect == nullptr) {
    return false;
  }
  const std::vector<NamedValue> values = parameters(fit, name);
  double size = values[0].value;
  if (name == "steady_wind" || name == "body_bias") {
    size = std::hypot(values[0].value, values[1].value);
  } else if (name == "tilt_gain" || name == "thrust_gain") {
    size = std::abs(size - 1.0);
  } else if (name == "time_offset" || name == "yaw_misalignment") {
    size = std::abs(size);
  } else if (name == "periodic_wind") {
    size = std::hypot(values[1].value, values[2].value);
    return size >= effect->smallest && own_motion_at(fit).empty() && keeps_time(fit);
  }
  return size >= effect->smallest;  // signed: drag, inflow and lag that push are none
}

bool TranslationFamily::alias(const Fit& winner, const std::string& name, const std::string& rival) const {
  if (!can_see(rival) || linear_count(winner.structure, name) == 0 || has(winner.structure, rival.c_str())) {
    return false;
  }
  const Searched searched = as_searched(winner.parameters);
  const Regression own(training_, winner.structure, searched);
  const auto first = static_cast<Eigen::Index>(column_of(winner.structure, name));
  const auto count = static_cast<Eigen::Index>(linear_count(winner.structure, name));
  const Vector acts =
      own.columns.middleCols(first, count) *
      Eigen::Map<const Vector>(winner.parameters.data() + kSearched, own.columns.cols()).segment(first, count);
  const Structure alone{"rigid_body", rival};
  if (linear_count(alone, rival) == 0 || rival == "periodic_wind") {
    return false;
  }
  const Regression other(training_, alone, searched);
  Matrix normal = other.columns.transpose() * other.columns;
  normal.diagonal().array() += 1e-9 * normal.trace() + 1e-12;
  const Vector fitted = other.columns * normal.ldlt().solve(other.columns.transpose() * acts);
  return acts.squaredNorm() > 0.0 && (acts - fitted).squaredNorm() < (1.0 - kAliasShare) * acts.squaredNorm();
}

bool TranslationFamily::keeps_time(const Fit& fit) const {
  const std::size_t fitted = (3 * block_count()) / 5;
  std::vector<int> early(block_count(), 0);
  std::fill_n(early.begin(), fitted, 1);
  std::vector<int> late(block_count(), 1);
  std::fill_n(late.begin(), fitted, 0);
  const auto sum_of = [&](const Fit& one) {
    double sum = 0.0;
    for (const std::vector<double>& block : errors(one, late)) {
      sum = std::inner_product(block.begin(), block.end(), block.begin(), sum);
    }
    return sum;
  };
  const Structure rest = without(fit.structure, "periodic_wind");
  const std::vector<int> all(block_count(), 1);
  const double without_line = sum_of(this->fit(rest, all, nullptr));
  const double with_line = sum_of(fit);
  const double foretold = sum_of(this->fit(fit.structure, early, &fit));
  return without_line - foretold > kForetoldShare * (without_line - with_line);
}

double TranslationFamily::preference(const TranslationBlocks& present, const TranslationBlocks& other) {
  Structure all{"rigid_body", "steady_wind", "body_bias", "tilt_gain"};
  if (present.data->has_velocity) {
    all.emplace_back("linear_drag");
  }
  const Vector y = measured_rows(present);
  Searched searched;
  double coefficient = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    Structure structure = all;
    if (pass == 1) {
      structure.emplace_back("periodic_wind");
    }
    const Regression model(present, structure, searched);
    const Vector difference = Regression(other, {"rigid_body"}, Searched{}).base - model.base;
    Matrix columns(model.columns.rows(), model.columns.cols() + 1);
    columns << model.columns, difference;
    const Vector target = y - model.base;
    Matrix normal = columns.transpose() * columns;
    normal.diagonal().array() += 1e-9 * normal.trace() + 1e-12;
    const Vector solution = normal.ldlt().solve(columns.transpose() * target);
    coefficient = solution(solution.size() - 1);
    const Vector left = target - columns * solution;
    searched.frequency_hz =
        strongest_line({axis_series(present, left, 0, {}), axis_series(present, left, 1, {})}).frequency_hz;
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

std::string TranslationFamily::own_motion_at(const Fit& fit) const {
  const Searched searched = as_searched(fit.parameters);
  const std::size_t column = kSearched + column_of(fit.structure, "periodic_wind");
  Structure rest = fit.structure;
  rest.erase(std::find(rest.begin(), rest.end(), "periodic_wind"));
  Fit plain = fit;
  plain.structure = rest;
  plain.parameters.erase(plain.parameters.begin() + static_cast<std::ptrdiff_t>(column),
                         plain.parameters.begin() + static_cast<std::ptrdiff_t>(column + 4));
  const Vector left = residual_of(training_, measured_rows(training_), plain);
  OwnMotion motion{.frequency_hz = searched.frequency_hz, .force = {}, .residual = {}, .channels = {}, .speed_m_s = {}};
  for (std::size_t n = 0; n < 2; ++n) {
    motion.force[n] = {fit.parameters[column + 2 * n], fit.parameters[column + 2 * n + 1]};
    motion.residual[n] = axis_series(training_, left, n, {});
  }
  const TranslationData& data = *training_.data;
  const auto channel = [&](const std::string& name, const std::vector<double>& values, int moved_by) {
    motion.channels.push_back({.name = name, .moved_by_axis = moved_by, .values = {}});
    for (const auto& block : training_.blocks) {
      for (const std::size_t i : block.samples) {
        motion.channels.back().values.push_back(values[i]);
      }
    }
  };
  if (data.has_velocity) {
    channel("velocity_x", data.velocity[0], 0);
    channel("velocity_y", data.velocity[1], 1);
    channel("velocity_z", data.velocity[2], -1);
    for (const auto& block : training_.blocks) {
      for (const std::size_t i : block.samples) {
        motion.speed_m_s.push_back(std::hypot(data.velocity[0][i], data.velocity[1][i], data.velocity[2][i]));
      }
    }
  }
  channel("tilt_x", data.direction[0], -1);
  channel("tilt_y", data.direction[1], -1);
  channel("thrust", data.thrust, -1);
  return judge_own_motion(motion);
}

}  // namespace m100::tools::identify
