// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/structure_spread.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/identify/selection/criteria.h"

namespace m100::lab::identify {
namespace {

/// Weight of an alternative against the fit's own, which is 1.
double weight(const Fit& fit, const std::vector<std::vector<double>>& own, const Fit& alternative,
              const std::vector<std::vector<double>>& others) {
  constexpr double kCertain = 40.0;
  const bool more = alternative.free_parameters >= fit.free_parameters;
  const std::size_t extra =
      more ? alternative.free_parameters - fit.free_parameters : fit.free_parameters - alternative.free_parameters;
  const double criterion = more ? whitened_criterion(own, others, extra) : -whitened_criterion(others, own, extra);
  return std::exp(0.5 * std::min(criterion, kCertain));
}

}  // namespace

std::vector<double> structure_spread(const Problem& problem, const Fit& fit, const std::vector<Fit>& alternatives) {
  const Family& family = problem.family();
  const auto own = training_errors(family, fit);
  const std::vector<Problem::Parameter> parameters = problem.parameters(fit);
  const std::vector<double> values = problem.coordinates(fit);
  std::vector<double> squares(values.size(), 0.0);
  std::vector<double> weights(values.size(), 1.0);
  for (const Fit& alternative : alternatives) {
    const double share = weight(fit, own, alternative, training_errors(family, alternative));
    const std::vector<Problem::Parameter> others = problem.parameters(alternative);
    const std::vector<double> moved = problem.coordinates(alternative);
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const auto same = std::find_if(others.begin(), others.end(), [&](const Problem::Parameter& one) {
        return one.effect == parameters[k].effect && one.value.name == parameters[k].value.name;
      });
      if (same != others.end()) {
        const double distance = moved[static_cast<std::size_t>(same - others.begin())] - values[k];
        squares[k] += share * distance * distance;
        weights[k] += share;
      }
    }
  }
  std::transform(squares.begin(), squares.end(), weights.begin(), squares.begin(),
                 [](double square, double total) { return std::sqrt(square / total); });
  return squares;
}

}  // namespace m100::lab::identify
