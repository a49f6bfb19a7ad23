// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"
#include "host_tests/tools/identify/selection.h"
#include "host_tests/tools/identify/translation_data.h"

namespace m100::tools::identify::translation {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

struct Effect {
  const char* name;
  std::vector<const char*> parameters;
  double smallest;  ///< of the size below: less has no physical meaning for a controller
};

/// All that can be added to the rigid body.
const std::vector<Effect>& effects();
/// Null where there is none of that name.
const Effect* effect_named(const std::string& name);

bool has(const Structure& structure, const char* name);

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

Searched as_searched(std::span<const double> v);
/// Which of them the structure has, in their order.
std::array<bool, kSearched> searched_in(const Structure& structure);
/// With wind and quadratic drag, it is the wind's speed that is searched and not its acceleration that is linear.
bool wind_speed_matters(const Structure& structure);

/// How many linear parameters an effect has beside the others, and all of them together.
std::size_t linear_count(const Structure& structure, const std::string& name);
std::size_t linear_count(const Structure& structure);
/// Column of the first linear parameter of an effect.
std::size_t column_of(const Structure& structure, const std::string& wanted);

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
  std::array<std::vector<double>, 3> thrust_vector_;
  std::array<std::vector<double>, 3> axis_;
};

}  // namespace m100::tools::identify::translation
