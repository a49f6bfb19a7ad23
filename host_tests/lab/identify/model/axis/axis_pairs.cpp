// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_pairs.h"

#include <algorithm>
#include <utility>

#include "host_tests/lab/identify/model/axis/axis_structure.h"

// After our eigen.h, which redirects the checks.
#include <Eigen/QR>

namespace m100::lab::identify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Share of the residual's power that two directions explain together. A step that is not taken in its own direction
/// is no effect: a dead zone has no negative width.
double explained(double aa, double bb, double ab, double ar, double br) {
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-6 * aa * bb)) {
    return 0.0;
  }
  const double a = (bb * ar - ab * br) / determinant;
  const double b = (aa * br - ab * ar) / determinant;
  return a > 0.0 && b > 0.0 ? a * ar + b * br : 0.0;
}

/// Whether an effect's number lies on either side of no effect, as that of a trim does.
bool is_signed(const Family::Edit& edit) {
  const std::vector<AxisParameter> parameters = parameters_of(edit.structure);
  return std::any_of(parameters.begin(), parameters.end(), [&](const AxisParameter& one) {
    return one.effect->name == edit.name && one.number->min_relevant > 0.0 && one.number->fit.low < one.number->neutral;
  });
}

}  // namespace

std::vector<Family::HiddenPair> best_pairs(const Vector& residual, const Matrix& base,
                                           const std::vector<EditDirection>& directions, std::size_t count) {
  Matrix columns(residual.size(), static_cast<Eigen::Index>(directions.size()) + 1);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    columns.col(static_cast<Eigen::Index>(k)) = directions[k].change;
  }
  columns.col(columns.cols() - 1) = residual;
  if (base.cols() > 0) {
    columns -= base * base.colPivHouseholderQr().solve(columns);
  }
  const Matrix gram = columns.transpose() * columns;
  const Eigen::Index r = gram.cols() - 1;
  struct Ranked {
    double explained;
    Family::HiddenPair pair;
  };
  std::vector<Ranked> ranked;
  for (Eigen::Index i = 0; i < r; ++i) {
    for (Eigen::Index k = i + 1; k < r; ++k) {
      const std::string& a = directions[static_cast<std::size_t>(i)].edit;
      const std::string& b = directions[static_cast<std::size_t>(k)].edit;
      if (a != b) {
        ranked.push_back({explained(gram(i, i), gram(k, k), gram(i, k), gram(i, r), gram(k, r)), {a, b}});
      }
    }
  }
  std::sort(ranked.begin(), ranked.end(), [](const Ranked& x, const Ranked& y) { return x.explained > y.explained; });
  std::vector<Family::HiddenPair> out;
  for (const Ranked& one : ranked) {
    const bool known = std::any_of(out.begin(), out.end(), [&](const Family::HiddenPair& pair) {
      return pair.first == one.pair.first && pair.second == one.pair.second;
    });
    if (!known && one.explained > 0.0 && out.size() < count) {
      out.push_back(one.pair);
    }
  }
  return out;
}

std::vector<Family::HiddenPair> pairs_around(const AxisFamily& family, const AxisBlocks& training, const Fit& from) {
  constexpr std::size_t kOffered = 3;
  const auto response = [&](const Fit& fit) {
    const std::vector<double> values = training.response(family.model(fit));
    return Vector(Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const Vector now = response(from);
  std::vector<double> error(training.samples());
  training.error(family.model(from), {}, error);
  const Vector residual = -Eigen::Map<const Vector>(error.data(), static_cast<Eigen::Index>(error.size()));
  const std::vector<AxisParameter> parameters = parameters_of(from.structure);
  Matrix base(now.size(), static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    Fit moved = from;
    moved.parameters[k] += parameters[k].number->step;
    base.col(static_cast<Eigen::Index>(k)) = response(moved) - now;
  }
  std::vector<EditDirection> directions;
  for (const Family::Edit& edit : family.edits(from.structure)) {
    for (const Fit& start : family.starts_with_effect(edit, from)) {
      directions.push_back({edit.name, response(start) - now});
      if (is_signed(edit)) {
        directions.push_back({edit.name, -directions.back().change});
      }
    }
  }
  return best_pairs(residual, base, directions, kOffered);
}

}  // namespace m100::lab::identify
