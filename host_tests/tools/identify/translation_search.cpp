// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/translation_search.h"

namespace m100::tools::identify::translation {

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

Vector residual_of(const TranslationBlocks& part, const Vector& measured, const Fit& fit) {
  const Searched searched = as_searched(fit.parameters);
  const Regression model(part, fit.structure, searched);
  Vector out = measured - model.base;
  if (model.columns.cols() > 0) {
    out.noalias() -= model.columns * Eigen::Map<const Vector>(fit.parameters.data() + kSearched, model.columns.cols());
  }
  return out;
}

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

}  // namespace m100::tools::identify::translation
