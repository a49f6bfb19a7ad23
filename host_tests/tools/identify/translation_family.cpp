// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/translation_family.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "host_tests/tools/identify/periodic.h"

namespace m100::tools::identify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kLongestLag_s = 0.5;
constexpr double kLongestOffset_s = 0.3;
constexpr double kStrongestWind_m_s = 40.0;
constexpr double kLargestAngle_rad = 1.0;
constexpr double kAliasShare = 0.97;
constexpr double kForetoldShare = 0.5;

struct Effect {
  const char* name;
  std::vector<const char*> parameters;
  double smallest;  ///< of the size below: less has no physical meaning for a controller
};

// steady_wind and body_bias: m/s^2; drags 1/s and 1/m; gains: difference to one; lag, offset: s; angle: rad; periodic:
// m/s^2
const std::vector<Effect>& effects() {
  static const std::vector<Effect> kEffects{
      {"steady_wind", {"accel_x_m_s2", "accel_y_m_s2"}, 0.06},
      {"body_bias", {"accel_x_m_s2", "accel_y_m_s2"}, 0.06},
      {"linear_drag", {"rate_per_s"}, 0.03},
      {"quadratic_drag", {"coefficient_per_m"}, 0.008},
      {"tilt_gain", {"gain"}, 0.03},
      {"thrust_gain", {"gain"}, 0.01},
      {"thrust_lag", {"lag_s"}, 0.012},
      {"axial_inflow", {"coefficient_per_s"}, 0.03},
      {"time_offset", {"offset_s"}, 0.012},
      {"yaw_misalignment", {"angle_rad"}, 0.03},
      {"periodic_wind", {"frequency_hz", "amplitude_x_m_s2", "amplitude_y_m_s2"}, 0.05}};
  return kEffects;
}

const Effect* effect_named(const std::string& name) {
  const auto found = std::find_if(effects().begin(), effects().end(), [&](const Effect& e) { return name == e.name; });
  return found == effects().end() ? nullptr : &*found;
}

bool has(const Structure& structure, const char* name) {
  return std::find(structure.begin(), structure.end(), name) != structure.end();
}

/// What is searched; the rest is linear. Also the head of a fit's parameters, followed by the linear ones.
struct Searched {
  double lag_s = 0.0;
  double offset_s = 0.0;
  double frequency_hz = 0.0;
  double wind_x_m_s = 0.0;
  double wind_y_m_s = 0.0;
  double angle_rad = 0.0;
};
constexpr std::size_t kSearched = 6;

Searched as_searched(std::span<const double> v) { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }

bool wind_speed_matters(const Structure& structure) {
  return has(structure, "steady_wind") && has(structure, "quadratic_drag");
}

std::array<bool, kSearched> searched_in(const Structure& structure) {
  const bool wind = wind_speed_matters(structure);
  return {has(structure, "thrust_lag"),      has(structure, "time_offset"), has(structure, "periodic_wind"), wind, wind,
          has(structure, "yaw_misalignment")};
}

std::size_t linear_count(const Structure& structure, const std::string& name) {
  if (name == "rigid_body" || name == "thrust_lag" || name == "time_offset" || name == "yaw_misalignment") {
    return 0;
  }
  if (name == "periodic_wind") {
    return 4;
  }
  if (name == "steady_wind") {
    return wind_speed_matters(structure) ? 0 : 2;
  }
  return name == "body_bias" ? 2 : 1;
}

std::size_t linear_count(const Structure& structure) {
  std::size_t count = 0;
  for (const std::string& name : structure) {
    count += linear_count(structure, name);
  }
  return count;
}

/// Column of the first linear parameter of an effect.
std::size_t column_of(const Structure& structure, const std::string& wanted) {
  std::size_t column = 0;
  for (const std::string& name : structure) {
    if (name == wanted) {
      break;
    }
    column += linear_count(structure, name);
  }
  return column;
}

using Series3 = std::array<std::vector<double>, 3>;

/// Linear models of one part of a log: y = base + columns * linear parameters.
class Regression {
 public:
  Regression(const TranslationBlocks& part, const Structure& structure, const Searched& searched)
      : part_(part), data_(*part.data), structure_(structure), searched_(searched) {
    make_thrust();
    const auto rows = static_cast<Eigen::Index>(part.rows);
    base = Vector::Zero(rows);
    columns = Matrix::Zero(rows, static_cast<Eigen::Index>(linear_count(structure)));
    fill(base, [this](std::size_t c, std::size_t i) {
      return thrust_vector_[c][i] - (c == 2 ? kStandardGravity_m_s2 : 0.0);
    });
    Eigen::Index column = 0;
    for (const std::string& name : structure) {
      add(name, column);
      column += static_cast<Eigen::Index>(linear_count(structure, name));
    }
  }

  Vector base;
  Matrix columns;

 private:
  /// T b3 after lag and offset.
  void make_thrust() {
    std::vector<double> lagged = data_.thrust;
    if (searched_.lag_s > 0.0) {
      const double share = 1.0 - std::exp(-data_.period_s / searched_.lag_s);
      for (std::size_t i = 1; i < lagged.size(); ++i) {
        // The set point between two samples is their mean: exact to second order for a slow input.
        lagged[i] = lagged[i - 1] + share * (0.5 * (data_.thrust[i] + data_.thrust[i - 1]) - lagged[i - 1]);
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      thrust_vector_[c].resize(lagged.size());
      axis_[c] = earlier(data_.direction[c]);
      const std::vector<double> moved = c == 0 ? lagged = earlier(lagged) : lagged;
      for (std::size_t i = 0; i < lagged.size(); ++i) {
        thrust_vector_[c][i] = moved[i] * axis_[c][i];
      }
    }
    if (searched_.angle_rad != 0.0) {
      turn();
    }
  }

  /// Turns the thrust about the vertical: the heading reference of tilt against that of velocity.
  void turn() {
    const double c = std::cos(searched_.angle_rad);
    const double s = std::sin(searched_.angle_rad);
    for (auto* vector : {&thrust_vector_, &axis_}) {
      for (std::size_t i = 0; i < (*vector)[0].size(); ++i) {
        const double x = (*vector)[0][i];
        (*vector)[0][i] = c * x - s * (*vector)[1][i];
        (*vector)[1][i] = s * x + c * (*vector)[1][i];
      }
    }
  }

  std::vector<double> earlier(const std::vector<double>& values) const {
    if (searched_.offset_s == 0.0) {
      return values;
    }
    std::vector<double> out(values.size());
    const double last = static_cast<double>(values.size() - 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double at = std::clamp(static_cast<double>(i) - searched_.offset_s / data_.period_s, 0.0, last - 1e-9);
      const auto k = static_cast<std::size_t>(at);
      const double share = at - static_cast<double>(k);
      out[i] = values[k] + share * (values[std::min(k + 1, values.size() - 1)] - values[k]);
    }
    return out;
  }

  /// Fills rows with the filtered acceleration u(axis, sample).
  template <typename Column, typename Acceleration>
  void fill(Column&& out, Acceleration&& u) const {
    std::vector<double> raw(data_.valid.size());
    for (std::size_t c = 0; c < data_.axes; ++c) {
      for (std::size_t i = 0; i < raw.size(); ++i) {
        raw[i] = u(c, i);
      }
      each_row(c, [&](Eigen::Index row, std::size_t i) { out(row) = data_.filtered(raw, i); });
    }
  }

  template <typename Act>
  void each_row(std::size_t axis, Act&& act) const {
    for (const TranslationBlocks::Block& block : part_.blocks) {
      std::size_t row = block.row + axis * block.samples.size();
      for (const std::size_t i : block.samples) {
        act(static_cast<Eigen::Index>(row++), i);
      }
    }
  }

  /// Fills rows with what the log shows of an outer acceleration u(axis, sample).
  template <typename Column, typename Acceleration>
  void fill_outer(Column&& out, Acceleration&& u) const {
    if (data_.shown == Shown::kWhole) {
      fill(out, u);
      return;
    }
    constexpr double kSteepest = 0.3;
    fill(out, [&](std::size_t c, std::size_t i) {
      const double taken = data_.shown == Shown::kAcross
                               ? u(0, i) * axis_[0][i] + u(1, i) * axis_[1][i] + u(2, i) * axis_[2][i]
                               : u(2, i) / std::max(kSteepest, axis_[2][i]);
      return u(c, i) - taken * axis_[c][i];
    });
  }

  double air_speed(std::size_t c, std::size_t i) const {
    const double wind = c == 0 ? searched_.wind_x_m_s : (c == 1 ? searched_.wind_y_m_s : 0.0);
    return data_.velocity[c][i] - wind;
  }

  void add(const std::string& name, Eigen::Index at) {
    const auto horizontal = [](std::size_t c, double value) { return c < 2 ? value : 0.0; };
    if (name == "steady_wind" && linear_count(structure_, name) > 0) {
      for (std::size_t n = 0; n < 2; ++n) {
        fill_outer(columns.col(at + static_cast<Eigen::Index>(n)),
                   [n](std::size_t c, std::size_t) { return c == n ? 1.0 : 0.0; });
      }
    } else if (name == "body_bias") {
      fill_outer(columns.col(at), [&](std::size_t c, std::size_t i) {
        return c == 0 ? std::cos(data_.yaw_rad[i]) : horizontal(c, std::sin(data_.yaw_rad[i]));
      });
      fill_outer(columns.col(at + 1), [&](std::size_t c, std::size_t i) {
        return c == 0 ? -std::sin(data_.yaw_rad[i]) : horizontal(c, std::cos(data_.yaw_rad[i]));
      });
    } else if (name == "linear_drag") {
      fill_outer(columns.col(at), [&](std::size_t c, std::size_t i) { return -air_speed(c, i); });
    } else if (name == "quadratic_drag") {
      fill_outer(columns.col(at), [&](std::size_t c, std::size_t i) {
        const double speed = std::hypot(air_speed(0, i), air_speed(1, i), air_speed(2, i));
        return -speed * air_speed(c, i);
      });
    } else if (name == "tilt_gain") {
      fill(columns.col(at), [&](std::size_t c, std::size_t i) { return horizontal(c, thrust_vector_[c][i]); });
    } else if (name == "thrust_gain") {
      fill(columns.col(at), [&](std::size_t c, std::size_t i) { return thrust_vector_[c][i]; });
    } else if (name == "axial_inflow") {
      fill(columns.col(at), [&](std::size_t c, std::size_t i) {
        double along = 0.0;
        for (std::size_t n = 0; n < 3; ++n) {
          along += axis_[n][i] * air_speed(n, i);
        }
        return -along * axis_[c][i];
      });
    } else if (name == "periodic_wind") {
      add_periodic(at);
    }
  }

  void add_periodic(Eigen::Index at) {
    const double omega = 2.0 * std::numbers::pi * searched_.frequency_hz;
    for (std::size_t n = 0; n < 2; ++n) {
      const Eigen::Index column = at + 2 * static_cast<Eigen::Index>(n);
      fill_outer(columns.col(column),
                 [&](std::size_t c, std::size_t i) { return c == n ? std::cos(omega * data_.time_s(i)) : 0.0; });
      fill_outer(columns.col(column + 1),
                 [&](std::size_t c, std::size_t i) { return c == n ? std::sin(omega * data_.time_s(i)) : 0.0; });
    }
  }

  const TranslationBlocks& part_;
  const TranslationData& data_;
  const Structure& structure_;
  const Searched& searched_;
  Series3 thrust_vector_;
  Series3 axis_;
};

Vector measured_rows(const TranslationBlocks& part) {
  Vector y(static_cast<Eigen::Index>(part.rows));
  for (const TranslationBlocks::Block& block : part.blocks) {
    std::size_t row = block.row;
    for (std::size_t c = 0; c < part.data->axes; ++c) {
      for (const std::size_t i : block.samples) {
        y(static_cast<Eigen::Index>(row++)) = part.data->measured[c][i];
      }
    }
  }
  return y;
}

struct Solution {
  Vector linear;
  double sum_of_squares = 0.0;
};

/// Weighted least squares for given searched parameters.
Solution solve(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
               const Searched& searched, std::span<const int> weights) {
  const Regression model(part, structure, searched);
  const Vector target = measured - model.base;
  const Eigen::Index n = model.columns.cols();
  Matrix normal = Matrix::Zero(n, n);
  Vector right = Vector::Zero(n);
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (weights[b] <= 0) {
      continue;
    }
    const auto row = static_cast<Eigen::Index>(part.blocks[b].row);
    const auto count = static_cast<Eigen::Index>(part.blocks[b].samples.size() * part.data->axes);
    const Matrix columns = model.columns.middleRows(row, count);
    normal.noalias() += weights[b] * columns.transpose() * columns;
    right.noalias() += weights[b] * columns.transpose() * target.segment(row, count);
  }
  Solution out{.linear = Vector::Zero(n), .sum_of_squares = 0.0};
  if (n > 0) {
    normal.diagonal().array() += 1e-9 * normal.trace() + 1e-12;
    out.linear = normal.ldlt().solve(right);
  }
  const Vector error = model.columns * out.linear - target;
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (weights[b] > 0) {
      const auto count = static_cast<Eigen::Index>(part.blocks[b].samples.size() * part.data->axes);
      out.sum_of_squares +=
          weights[b] * error.segment(static_cast<Eigen::Index>(part.blocks[b].row), count).squaredNorm();
    }
  }
  // Drag that pushes is no drag; nor is the wind speed then defined.
  if (wind_speed_matters(structure) &&
      out.linear(static_cast<Eigen::Index>(column_of(structure, "quadratic_drag"))) < 0) {
    out.sum_of_squares *= 10.0;
  }
  return out;
}

/// Coordinate search with shrinking steps: the few searched parameters are nearly independent of each other.
class Search {
 public:
  Search(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
         std::span<const int> weights)
      : part_(part), measured_(measured), structure_(structure), weights_(weights), used_(searched_in(structure)) {}

  double cost(const std::array<double, kSearched>& at) const {
    const Searched searched = as_searched(at);
    return solve(part_, measured_, structure_, searched, weights_).sum_of_squares;
  }

  void refine(std::array<double, kSearched>& at, std::array<double, kSearched> steps, int rounds) const {
    const std::array<double, kSearched> low{
        0.0, -kLongestOffset_s, 0.02, -kStrongestWind_m_s, -kStrongestWind_m_s, -kLargestAngle_rad};
    const std::array<double, kSearched> high{kLongestLag_s,      kLongestOffset_s,   10.0,
                                             kStrongestWind_m_s, kStrongestWind_m_s, kLargestAngle_rad};
    double best = cost(at);
    for (int round = 0; round < rounds; ++round) {
      bool moved = false;
      for (std::size_t k = 0; k < kSearched; ++k) {
        if (!used_[k]) {
          continue;
        }
        for (const double sign : {1.0, -1.0}) {
          std::array<double, kSearched> trial = at;
          trial[k] = std::clamp(at[k] + sign * steps[k], low[k], high[k]);
          const double value = cost(trial);
          if (value < best) {
            best = value;
            at = trial;
            moved = true;
            break;
          }
        }
      }
      if (!moved) {
        for (double& step : steps) {
          step *= 0.4;
        }
      }
    }
  }

  bool anything() const { return std::find(used_.begin(), used_.end(), true) != used_.end(); }

 private:
  const TranslationBlocks& part_;
  const Vector& measured_;
  const Structure& structure_;
  std::span<const int> weights_;
  std::array<bool, kSearched> used_;
};

Vector residual_of(const TranslationBlocks& part, const Vector& measured, const Fit& fit) {
  const Searched searched = as_searched(fit.parameters);
  const Regression model(part, fit.structure, searched);
  Vector out = measured - model.base;
  if (model.columns.cols() > 0) {
    out.noalias() -= model.columns * Eigen::Map<const Vector>(fit.parameters.data() + kSearched, model.columns.cols());
  }
  return out;
}

/// Residual of one axis with its times, for the line search.
LineSeries axis_series(const TranslationBlocks& part, const Vector& residual, std::size_t axis,
                       std::span<const int> weights) {
  LineSeries out;
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (!weights.empty() && weights[b] <= 0) {
      continue;
    }
    const auto& block = part.blocks[b];
    std::size_t row = block.row + axis * block.samples.size();
    for (const std::size_t i : block.samples) {
      out.time_s.push_back(part.data->time_s(i));
      out.values.push_back(residual(static_cast<Eigen::Index>(row++)));
    }
  }
  return out;
}

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
