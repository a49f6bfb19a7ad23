// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/flight_winds.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

// Included after firmware/core/eigen.h, which makes Eigen's assertions call ours.
#include <Eigen/Cholesky>

#include "host_tests/lab/identify/model/translation/coordinate_search.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify::translation {
namespace {

constexpr const char* kWind = "steady_wind";

Matrix wind_columns(const TranslationBlocks& part) {
  return Regression(part, {"rigid_body", kWind}, SearchPoint{}).columns;
}

std::size_t flight_of(const TranslationBlocks& part, std::size_t block) {
  return part.data->flight_of(part.blocks[block].samples.front());
}

struct RowsOf {
  Eigen::Index first;
  Eigen::Index count;
};
RowsOf rows_of(const TranslationBlocks& part, std::size_t block) {
  return {static_cast<Eigen::Index>(part.blocks[block].row),
          static_cast<Eigen::Index>(part.blocks[block].samples.size() * part.data->axes)};
}

/// Least squares over the blocks of each flight. @param seen  set to 1 for each flight that has a block
Winds least_squares(const TranslationBlocks& part, const Matrix& columns, const Vector& rows,
                    std::span<const int> weights, std::vector<char>& seen) {
  const std::size_t flights = part.data->flights.size();
  std::vector<Eigen::Matrix2d> normal(flights, Eigen::Matrix2d::Identity() * 1e-12);
  Winds out = Winds::Zero(2, static_cast<Eigen::Index>(flights));
  seen.assign(flights, 0);
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    const int weight = weights.empty() ? 1 : weights[b];
    if (weight <= 0) {
      continue;
    }
    const auto [first, count] = rows_of(part, b);
    const std::size_t flight = flight_of(part, b);
    const Matrix own = columns.middleRows(first, count);
    normal[flight].noalias() += weight * own.transpose() * own;
    out.col(static_cast<Eigen::Index>(flight)).noalias() += weight * own.transpose() * rows.segment(first, count);
    seen[flight] = 1;
  }
  for (std::size_t flight = 0; flight < flights; ++flight) {
    const auto k = static_cast<Eigen::Index>(flight);
    const Eigen::Vector2d right = out.col(k);
    out.col(k) = normal[flight].ldlt().solve(right);
  }
  return out;
}

Vector rows_left(const TranslationBlocks& part, const Fit& fit) { return residual_of(part, measured_rows(part), fit); }

}  // namespace

FlightWinds::FlightWinds(const TranslationBlocks& part)
    : part_(part), own_(part.data->winds_per_flight && part.head == nullptr), head_(part.head != nullptr) {
  if (active()) {
    columns_ = wind_columns(part);
  }
  if (head_) {
    head_columns_ = wind_columns(*part.head);
  }
}

Winds FlightWinds::of(const Vector& rows, const Vector& head, std::span<const int> weights) const {
  std::vector<char> seen;
  if (head_) {
    return least_squares(*part_.head, head_columns_, head, {}, seen);
  }
  Winds out = least_squares(part_, columns_, rows, weights, seen);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t flight = 0; flight < seen.size(); ++flight) {
    if (seen[flight] != 0) {
      mean += out.col(static_cast<Eigen::Index>(flight));
      count += 1.0;
    }
  }
  for (std::size_t flight = 0; flight < seen.size(); ++flight) {
    const auto k = static_cast<Eigen::Index>(flight);
    if (seen[flight] != 0) {
      out.col(k) -= mean / std::max(1.0, count);
    } else {
      out.col(k).setZero();
    }
  }
  return out;
}

void FlightWinds::take(const Winds& winds, Vector& rows) const {
  for (std::size_t b = 0; b < part_.blocks.size(); ++b) {
    const auto flight = static_cast<Eigen::Index>(flight_of(part_, b));
    if (flight < winds.cols()) {
      const auto [first, count] = rows_of(part_, b);
      rows.segment(first, count).noalias() -= columns_.middleRows(first, count) * winds.col(flight);
    }
  }
}

void FlightWinds::take_from(Matrix& columns, const Matrix& head_columns, Vector& target, const Vector& head_target,
                            std::span<const int> weights) const {
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Vector column = columns.col(k);
    take(of(column, head_ ? Vector(head_columns.col(k)) : Vector(), weights), column);
    columns.col(k) = column;
  }
  take(of(target, head_target, weights), target);
}

Winds winds_in(const Fit& fit) {
  const std::size_t first = kSearched + linear_count(fit.structure);
  const std::size_t count = fit.parameters.size() > first ? fit.parameters.size() - first : 0;
  return Eigen::Map<const Winds>(fit.parameters.data() + (count > 0 ? first : 0), 2,
                                 static_cast<Eigen::Index>(count / 2));
}

namespace {

/// The winds estimated from each block alone.
std::vector<Winds> winds_of_blocks(const TranslationBlocks& blocks, const Matrix& columns, const Vector& left) {
  std::vector<Winds> out;
  std::vector<char> seen;
  for (std::size_t b = 0; b < blocks.blocks.size(); ++b) {
    std::vector<int> only(blocks.blocks.size(), 0);
    only[b] = 1;
    out.push_back(least_squares(blocks, columns, left, only, seen));
  }
  return out;
}

/// A flight's wind, and its standard error from the deviations of its blocks from `middle`. One block gives neither.
FlightWind flight_wind(const TranslationBlocks& blocks, const std::vector<Winds>& by_block, std::size_t flight,
                       const Eigen::Vector2d& wind, const Eigen::Vector2d& middle) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (std::size_t b = 0; b < by_block.size(); ++b) {
    if (flight_of(blocks, b) == flight) {
      squares += (by_block[b].col(static_cast<Eigen::Index>(flight)) - middle).cwiseAbs2();
      n += 1.0;
    }
  }
  FlightWind out;
  out.known = n > 1.0;
  for (Eigen::Index c = 0; out.known && c < 2; ++c) {
    out.accel_m_s2[static_cast<std::size_t>(c)] = wind(c);
    out.sigma_m_s2[static_cast<std::size_t>(c)] = std::sqrt(squares(c) / (n * (n - 1.0)));
  }
  return out;
}

}  // namespace

std::vector<FlightWind> flight_winds(const TranslationDataSet& part, const Fit& fit) {
  const TranslationBlocks& blocks = part.blocks;
  const Vector left = rows_left(blocks, fit);
  const Matrix columns = wind_columns(blocks);
  const std::vector<Winds> by_block = winds_of_blocks(blocks, columns, left);
  std::vector<char> seen;
  Winds all = winds_in(fit);
  const Winds again = least_squares(blocks, columns, left, {}, seen);
  all = all.cols() == again.cols() ? Winds(all + again) : again;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double known = 0.0;
  std::vector<FlightWind> out;
  for (std::size_t flight = 0; flight < part.data.flights.size(); ++flight) {
    const auto k = static_cast<Eigen::Index>(flight);
    out.push_back(flight_wind(blocks, by_block, flight, all.col(k), again.col(k)));
    if (out.back().known) {
      mean += all.col(k);
      known += 1.0;
    }
  }
  for (FlightWind& wind : out) {
    for (std::size_t c = 0; wind.known && c < 2; ++c) {
      wind.accel_m_s2[c] -= mean(static_cast<Eigen::Index>(c)) / known;
    }
  }
  return out;
}

bool are_distinct(const std::vector<FlightWind>& winds) {
  constexpr double kStandardErrors = 4.0;
  const double least_m_s2 = model::translation_effect(kWind)->min_relevant;
  return std::any_of(winds.begin(), winds.end(), [&](const FlightWind& wind) {
    const auto beyond = [&](std::size_t c) {
      return std::abs(wind.accel_m_s2[c]) > std::max(least_m_s2, kStandardErrors * wind.sigma_m_s2[c]);
    };
    return wind.known && (beyond(0) || beyond(1));
  });
}

std::string describe(const std::vector<FlightWind>& winds) {
  std::string out = "each flight has a wind of its own; deviations from the mean wind (acceleration at rest, 95 %):";
  for (std::size_t k = 0; k < winds.size(); ++k) {
    out += winds[k].known ? printed("%s log %zu x %+.3f +-%.3f, y %+.3f +-%.3f m/s^2", k > 0 ? ";" : "", k + 1,
                                    winds[k].accel_m_s2[0], 1.96 * winds[k].sigma_m_s2[0], winds[k].accel_m_s2[1],
                                    1.96 * winds[k].sigma_m_s2[1])
                          : "";
  }
  return out;
}

std::size_t flight_without_head(const TranslationBlocks& part) {
  const TranslationBlocks& head = *part.head;
  std::vector<char> begun(part.data->flights.size(), 0);
  for (std::size_t b = 0; b < head.blocks.size(); ++b) {
    begun[flight_of(head, b)] = 1;
  }
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (begun[flight_of(part, b)] == 0) {
      return flight_of(part, b) + 1;
    }
  }
  return 0;
}

std::string describe_head_winds(const TranslationDataSet& part, const Fit& fit, double head_s) {
  const TranslationBlocks& head = *part.blocks.head;
  std::vector<char> seen;
  const Winds winds = least_squares(head, wind_columns(head), rows_left(head, fit), {}, seen);
  std::string out =
      printed("the wind of each flight was estimated in its first %.4g s (acceleration at rest):", head_s);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    out += seen[k] != 0 ? printed(" log %zu x %+.3f, y %+.3f m/s^2;", k + 1, winds(0, column), winds(1, column)) : "";
  }
  out.pop_back();
  return out;
}

}  // namespace m100::lab::identify::translation
