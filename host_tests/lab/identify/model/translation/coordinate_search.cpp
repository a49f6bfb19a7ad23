// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/coordinate_search.h"

#include <algorithm>
#include <utility>

#include "host_tests/lab/identify/model/translation/flight_winds.h"

namespace m100::lab::identify::translation {

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

namespace {

/// Whether any progressive drag has a coefficient of zero or less: it is then no drag, and leaves the wind undefined.
bool has_negative_drag(const Structure& structure, const Vector& linear) {
  return std::any_of(structure.begin(), structure.end(), [&](const std::string& name) {
    const model::TranslationEffect* effect = model::translation_effect(name);
    return effect != nullptr && effect->drag == model::Drag::kProgressive &&
           linear(static_cast<Eigen::Index>(column_of(structure, name))) <= 0.0;
  });
}

/// Bounds of the linear parameters. An effect that reports its linear parameters, as they are or as gains, also gives
/// their bounds; all other bounds are very wide.
struct Bounds {
  Vector low;
  Vector high;
};
Bounds bounds_of(const Structure& structure) {
  const auto n = static_cast<Eigen::Index>(linear_count(structure));
  Bounds out{Vector::Constant(n, -1e9), Vector::Constant(n, 1e9)};
  for (const std::string& name : structure) {
    const model::TranslationEffect* effect = model::translation_effect(name);
    const std::size_t count = linear_count(structure, name);
    if (effect == nullptr || count != effect->parameter_count() ||
        (effect->report != nullptr && effect->report != model::report_gain)) {
      continue;
    }
    const double neutral = effect->report == nullptr ? 0.0 : 1.0;
    const auto first = static_cast<Eigen::Index>(column_of(structure, name));
    for (std::size_t k = 0; k < count; ++k) {
      out.low(first + static_cast<Eigen::Index>(k)) = effect->parameters[k].low - neutral;
      out.high(first + static_cast<Eigen::Index>(k)) = effect->parameters[k].high - neutral;
    }
  }
  return out;
}

/// Moves parameters outside of the bounds onto them and marks them in `held`. @returns whether there were any.
bool clamp_to_bounds(const Bounds& bounds, Vector& x, std::vector<char>& held) {
  bool left = false;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (x(k) < bounds.low(k) || x(k) > bounds.high(k)) {
      x(k) = std::clamp(x(k), bounds.low(k), bounds.high(k));
      held[static_cast<std::size_t>(k)] = 1;
      left = true;
    }
  }
  return left;
}

/// Minimises x' N x / 2 - r' x over the parameters that are not held.
Vector solve_free(const Matrix& normal, const Vector& right, const Vector& x, const std::vector<char>& held) {
  Matrix reduced = normal;
  Vector rest = right;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (held[static_cast<std::size_t>(k)] != 0) {
      rest -= normal.col(k) * x(k);
    }
  }
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (held[static_cast<std::size_t>(k)] != 0) {
      reduced.row(k).setZero();
      reduced.col(k).setZero();
      reduced(k, k) = 1.0;
      rest(k) = x(k);
    }
  }
  return reduced.ldlt().solve(rest);
}

/// Minimises x' N x / 2 - r' x inside the bounds: parameters that leave them are held there, the others solved again.
Vector solve_inside(const Matrix& normal, const Vector& right, const Bounds& bounds) {
  Vector x = normal.ldlt().solve(right);
  std::vector<char> held(static_cast<std::size_t>(x.size()), 0);
  for (Eigen::Index pass = 0; pass < x.size() && clamp_to_bounds(bounds, x, held); ++pass) {
    x = solve_free(normal, right, x, held);
  }
  return x;
}

/// Eliminates the winds of the flights from a regression, which is then fitted as if there were none.
void take_winds(const TranslationBlocks& part, const Structure& structure, const SearchPoint& searched,
                std::span<const int> weights, const FlightWinds& winds, Matrix& columns, Vector& target) {
  if (part.head == nullptr) {
    winds.take_from(columns, {}, target, {}, weights);
    return;
  }
  const Regression head(*part.head, structure, searched);
  winds.take_from(columns, head.columns, target, measured_rows(*part.head) - head.base, weights);
}

/// The parameters that minimise x' N x - 2 r' x inside the structure's bounds.
Vector minimiser(Matrix normal, const Vector& right, const Structure& structure) {
  if (right.size() == 0) {
    return right;
  }
  normal.diagonal().array() += 1e-9 * normal.trace() + 1e-12;
  return solve_inside(normal, right, bounds_of(structure));
}

/// solve() with the flights' winds eliminated first. The elimination depends on the weights, so no cache is used.
Solution solve_with_winds(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
                          const SearchPoint& searched, std::span<const int> weights, const FlightWinds& winds) {
  Regression model(part, structure, searched);
  Vector target = measured - model.base;
  const Matrix whole_columns = model.columns;
  const Vector whole_target = target;
  take_winds(part, structure, searched, weights, winds, model.columns, target);
  const Eigen::Index n = model.columns.cols();
  Matrix normal = Matrix::Zero(n, n);
  Vector right = Vector::Zero(n);
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (weights[b] <= 0) {
      continue;
    }
    const auto row = static_cast<Eigen::Index>(part.blocks[b].row);
    const auto count = static_cast<Eigen::Index>(part.blocks[b].samples.size() * part.data->axes);
    const auto columns = model.columns.middleRows(row, count);
    normal.noalias() += weights[b] * columns.transpose() * columns;
    right.noalias() += weights[b] * columns.transpose() * target.segment(row, count);
  }
  Solution out{.linear = minimiser(std::move(normal), right, structure), .sum_of_squares = 0.0, .winds = {}};
  if (part.data->winds_per_flight && part.head == nullptr) {
    const Winds found = winds.of(whole_target - whole_columns * out.linear, {}, weights);
    out.winds.assign(found.data(), found.data() + found.size());
  }
  const Vector error = model.columns * out.linear - target;
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (weights[b] > 0) {
      const auto count = static_cast<Eigen::Index>(part.blocks[b].samples.size() * part.data->axes);
      out.sum_of_squares +=
          weights[b] * error.segment(static_cast<Eigen::Index>(part.blocks[b].row), count).squaredNorm();
    }
  }
  return out;
}

Solution solve_by_blocks(const BlockNormals& blocks, const Structure& structure, std::span<const int> weights) {
  const auto n = static_cast<Eigen::Index>(linear_count(structure));
  Matrix normal = Matrix::Zero(n, n);
  Vector right = Vector::Zero(n);
  double square = 0.0;
  for (std::size_t b = 0; b < weights.size(); ++b) {
    if (weights[b] > 0) {
      normal += weights[b] * blocks.normal[b];
      right += weights[b] * blocks.right[b];
      square += weights[b] * blocks.square[b];
    }
  }
  Solution out{.linear = minimiser(normal, right, structure), .sum_of_squares = square, .winds = {}};
  if (n > 0) {
    out.sum_of_squares = std::max(0.0, square + out.linear.dot(normal * out.linear - 2.0 * right));
  }
  return out;
}

}  // namespace

Solution solve(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
               const SearchPoint& searched, std::span<const int> weights, NormalEquations& normals) {
  const FlightWinds winds(part);
  Solution out = winds.active() ? solve_with_winds(part, measured, structure, searched, weights, winds)
                                : solve_by_blocks(normals.of(part, measured, structure, searched), structure, weights);
  if (is_wind_speed_searched(structure) && has_negative_drag(structure, out.linear)) {
    out.sum_of_squares *= 10.0;
  }
  return out;
}

bool CoordinateSearch::step_along(std::size_t slot, double step, SearchPoint& at, double& best) const {
  const model::SearchedParameter& range = slots()[slot].parameter();
  for (const double sign : {1.0, -1.0}) {
    SearchPoint trial = at;
    trial[slot] = std::clamp(at[slot] + sign * step, range.low, range.high);
    const double value = cost(trial);
    if (value < best) {
      best = value;
      at = trial;
      return true;
    }
  }
  return false;
}

void CoordinateSearch::refine(SearchPoint& at, double model::SearchedParameter::*step, int rounds) const {
  SearchPoint steps{};
  std::transform(slots().begin(), slots().end(), steps.begin(),
                 [&](const Slot& slot) { return slot.parameter().*step; });
  double best = cost(at);
  for (int round = 0; round < rounds; ++round) {
    bool moved = false;
    for (std::size_t k = 0; k < kSearched; ++k) {
      if (used_[k] && step_along(k, steps[k], at, best)) {
        moved = true;
      }
    }
    if (!moved) {
      for (double& one : steps) {
        one *= 0.4;
      }
    }
  }
}

bool CoordinateSearch::has_parameters() const { return std::find(used_.begin(), used_.end(), true) != used_.end(); }

Vector residual_of(const TranslationBlocks& part, const Vector& measured, const Fit& fit) {
  const Regression model(part, fit.structure, searched_of(fit));
  Vector out = measured - model.base;
  if (model.columns.cols() > 0) {
    out.noalias() -= model.columns * Eigen::Map<const Vector>(fit.parameters.data() + kSearched, model.columns.cols());
  }
  const FlightWinds winds(part);
  if (part.head != nullptr) {
    winds.take(winds.of(out, residual_of(*part.head, measured_rows(*part.head), fit), {}), out);
  } else if (winds.active()) {
    winds.take(winds_in(fit), out);
  }
  return out;
}

TimeSeries axis_series(const TranslationBlocks& part, const Vector& residual, std::size_t axis,
                       std::span<const int> weights) {
  TimeSeries out;
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

double strongest_peak_hz(const TranslationBlocks& part, const Vector& residual, std::span<const int> weights) {
  return strongest_peak({axis_series(part, residual, 0, weights), axis_series(part, residual, 1, weights)})
      .frequency_hz;
}

}  // namespace m100::lab::identify::translation
