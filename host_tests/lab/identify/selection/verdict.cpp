// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host_tests/lab/identify/selection/criteria.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

struct Power {
  double mean_square = 0.0;
  double degrees = 1.0;
};

Power power_of(const std::vector<std::vector<double>>& blocks) {
  constexpr double kForgotten = 0.05;
  const double samples = samples_of(blocks);
  const double power = lagged_product(blocks, 0);
  if (!(power > 0.0)) {
    return {0.0, std::max(1.0, samples)};
  }
  double squares = 1.0;
  double correlation = 0.0;
  for (std::size_t lag = 1; (correlation = lagged_product(blocks, lag) / power) >= kForgotten; ++lag) {
    squares += 2.0 * correlation * correlation;
  }
  return {power / samples, std::max(1.0, samples / squares)};
}

/// Blocks without their first samples; unchanged if no sample would remain.
std::vector<std::vector<double>> beyond(const std::vector<std::vector<double>>& blocks, std::size_t start) {
  std::vector<std::vector<double>> out;
  for (const std::vector<double>& block : blocks) {
    if (block.size() > start) {
      out.emplace_back(block.begin() + static_cast<std::ptrdiff_t>(start), block.end());
    }
  }
  return out.empty() ? blocks : out;
}

double mean_square(const std::vector<std::vector<double>>& blocks) {
  return lagged_product(blocks, 0) / std::max(1.0, samples_of(blocks));
}

/// Number of independent squares in a block, from the spread of the blocks' mean squares: a mean of n squares of a
/// Gaussian series has a variance of two over n times its own square. Gusty air is worth fewer squares than its
/// autocorrelation suggests, and so is an error that grows from the start of each block.
/// @returns infinity with fewer than eight blocks, or where they do not differ.
double squares_in_a_block(const std::vector<std::vector<double>>& blocks) {
  constexpr std::size_t kEnough = 8;
  double sum = 0.0;
  double squares = 0.0;
  for (const std::vector<double>& block : blocks) {
    const double power = std::inner_product(block.begin(), block.end(), block.begin(), 0.0) /
                         std::max(1.0, static_cast<double>(block.size()));
    sum += power;
    squares += power * power;
  }
  const double n = static_cast<double>(blocks.size());
  const double variance = (squares - sum * sum / std::max(1.0, n)) / std::max(1.0, n - 1.0);
  const double mean = sum / std::max(1.0, n);
  return blocks.size() >= kEnough && variance > 0.0 ? 2.0 * mean * mean / variance
                                                    : std::numeric_limits<double>::infinity();
}

/// Continued fraction of the incomplete beta function, by the modified Lentz algorithm.
double beta_fraction(double x, double a, double b) {
  constexpr double kTiny = 1e-300;
  constexpr int kTerms = 500;
  const auto away = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1.0;
  double d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
  double fraction = d;
  for (int term = 1; term <= kTerms; ++term) {
    const double m = term;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / away(1.0 + even * d);
    c = away(1.0 + even / c);
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / away(1.0 + odd * d);
    c = away(1.0 + odd / c);
    fraction *= d * c;
    if (std::abs(d * c - 1.0) < 1e-12) {
      break;
    }
  }
  return fraction;
}

/// Regularised incomplete beta function, 0 <= x <= 1.
double incomplete_beta(double x, double a, double b) {
  if (!(x > 0.0)) {
    return 0.0;
  }
  if (!(x < 1.0)) {
    return 1.0;
  }
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(1.0 - x));
  return x < (a + 1.0) / (a + b + 2.0) ? front * beta_fraction(x, a, b) / a
                                       : 1.0 - front * beta_fraction(1.0 - x, b, a) / b;
}

/// Whether the validation part looks like another vehicle's. If effects or changes were `named`, the ratio `maximum`
/// alone decides, otherwise the F test, too. The F test excuses a large ratio that is its own, without the starts.
bool is_another_vehicle(const ValidationComparison& parts, const CompletenessLimits& limits, bool named,
                        double maximum) {
  const double later = std::sqrt(parts.beyond_start);
  const bool by_chance = maximum <= later && parts.probability >= limits.min_evidence;
  return (maximum > limits.max_ratio && !by_chance) ||
         !(named || later < limits.min_ratio || parts.probability >= limits.min_probability);
}

}  // namespace

double f_tail(double ratio, double numerator_degrees, double denominator_degrees) {
  const double x = denominator_degrees / (denominator_degrees + numerator_degrees * std::max(0.0, ratio));
  return incomplete_beta(x, 0.5 * denominator_degrees, 0.5 * numerator_degrees);
}

ValidationComparison compare_validation(const std::vector<std::vector<double>>& training,
                                        const std::vector<std::vector<double>>& validation, std::size_t parameters,
                                        std::size_t start) {
  const std::vector<std::vector<double>> fitted = beyond(training, start);
  const std::vector<std::vector<double>> fresh = beyond(validation, start);
  Power seen = power_of(fitted);
  Power unseen = power_of(fresh);
  // The spread is that of the training blocks alone: bursts in the validation part must not widen its own tolerance.
  const double in_a_block = squares_in_a_block(fitted);
  seen.degrees = std::max(1.0, std::min(seen.degrees, in_a_block * static_cast<double>(fitted.size())));
  unseen.degrees = std::max(1.0, std::min(unseen.degrees, in_a_block * static_cast<double>(fresh.size())));
  ValidationComparison out;
  out.validation_degrees = unseen.degrees;
  out.training_degrees = std::max(1.0, seen.degrees - static_cast<double>(parameters));
  if (!(seen.mean_square > 0.0)) {
    return out;  // a perfect fit: synthetic data
  }
  out.ratio = mean_square(validation) / mean_square(training);
  out.beyond_start = unseen.mean_square / seen.mean_square;
  // The fit reduces the training error by its share of parameters.
  const double fair = out.beyond_start * out.training_degrees / seen.degrees;
  out.probability = fair > 1.0 ? f_tail(fair, out.validation_degrees, out.training_degrees) : 1.0;
  return out;
}

void check_completeness(const ValidationComparison& parts, const CompletenessLimits& limits, IdentifyResult& result) {
  const double rms_ratio = std::sqrt(parts.ratio);
  result.validation_over_training = rms_ratio;
  const bool at_floor =
      result.noise_floor > 0.0 && result.final_model.validation_rmse < limits.floor_factor * result.noise_floor;
  if (result.final_model.fit_percent < limits.min_fit_percent && !at_floor) {
    result.unexplained.push_back(printed("the model explains only %.0f %% of the motion in the validation part",
                                         std::max(0.0, result.final_model.fit_percent)));
  }
  if (parts.across_a_change) {
    return;
  }
  const double later_ratio = std::sqrt(parts.beyond_start);
  // The starts of the blocks are left out if slow rows do not determine the initial states, or if an effect was named:
  // a strong lead zero makes them wrong although its name is right. With a change the whole error is used, because a
  // wrong time of the change shows at the starts first.
  const bool starts_count = result.effects.empty() && parts.are_starts_measured;
  const double maximum = starts_count || !result.changes.empty() ? rms_ratio : later_ratio;
  if (is_another_vehicle(parts, limits, !result.effects.empty() || !result.changes.empty(), maximum)) {
    const bool alone = result.unexplained.empty();
    result.unexplained.push_back(printed(
        "the validation error is %.2f times the training error (limit %.2g; probability by chance %.1g, at least %.1g)",
        maximum > limits.max_ratio ? maximum : later_ratio, limits.max_ratio, parts.probability,
        limits.min_probability));
    if (alone) {
      result.findings.push_back(
          note("probably the air changed and the vehicle did not: the validation part is predicted worse, but no model "
               "parameter has another value there and no logged signal predicts the residual"));
    }
  }
}

bool forbids_nothing_missing(const Finding& finding) {
  return finding.what != "note" && finding.what != "gap" && finding.what != "on_ground";
}

std::string verdict_of(const IdentifyResult& result) {
  // Where the log itself is faulty, an effect that was found may be caused by the fault: it explains nothing.
  if (!result.unexplained.empty() ||
      std::any_of(result.findings.begin(), result.findings.end(), forbids_nothing_missing)) {
    return "unexplained";
  }
  return result.effects.empty() && result.changes.empty() ? "nothing_missing" : "explained";
}

}  // namespace m100::lab::identify
