// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/criteria.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "host_tests/lab/identify/model/whitening.h"

namespace m100::lab::identify {
namespace {

double paired_t(const std::vector<double>& without, const std::vector<double>& with) {
  const double n = static_cast<double>(without.size());
  double mean = 0.0;
  for (std::size_t block = 0; block < without.size(); ++block) {
    mean += (without[block] - with[block]) / n;
  }
  double variance = 0.0;
  for (std::size_t block = 0; block < without.size(); ++block) {
    const double offset = without[block] - with[block] - mean;
    variance += offset * offset / std::max(1.0, n - 1.0);
  }
  return variance > 0.0 ? mean / std::sqrt(variance / n) : 0.0;
}

/// Sum of squares without the first `start` samples of each block; of a block that is not longer, of all its samples.
double beyond_starts(const std::vector<std::vector<double>>& blocks, std::size_t start) {
  double sum = 0.0;
  for (const std::vector<double>& block : blocks) {
    const auto from = block.begin() + static_cast<std::ptrdiff_t>(block.size() > start ? start : 0);
    sum = std::inner_product(from, block.end(), from, sum);
  }
  return sum;
}

}  // namespace

Comparison compare(const CrossValidatedFit& without, const CrossValidatedFit& with, double samples, std::size_t start) {
  Comparison out;
  out.cv_gain = 1.0 - with.cv / without.cv;
  const double effective = with.effective_samples;
  out.delta_bic = information_criterion(without.fit.sum_of_squares / samples, effective, without.fit.free_parameters) -
                  information_criterion(with.fit.sum_of_squares / samples, effective, with.fit.free_parameters);
  out.t = paired_t(without.cv_block, with.cv_block);
  if (out.cv_gain > 0.0 && !with.errors.empty() && !without.errors.empty()) {
    const std::size_t more = with.fit.free_parameters, fewer = without.fit.free_parameters;
    out.delta_white = whitened_criterion(without.errors, with.errors, more > fewer ? more - fewer : 0);
    out.gain_beyond_starts = 1.0 - beyond_starts(with.errors, start) / beyond_starts(without.errors, start);
  }
  return out;
}

bool convincing(const Comparison& comparison, const SelectionOptions& options) {
  if (comparison.cv_gain <= options.minimum_cv_gain || comparison.gain_beyond_starts <= options.minimum_cv_gain) {
    return false;
  }
  const double least_t = comparison.delta_bic > 0.0 ? options.minimum_t_white : options.minimum_t;
  if (comparison.t > least_t && comparison.delta_white > options.minimum_delta_white) {
    return true;
  }
  // The criterion on the effective sample size (delta_bic) is inefficient in coloured air, and biased in a closed loop:
  // a stick that counteracts the air causes no motion, which looks like backlash. The whitened criterion must agree.
  return comparison.delta_white >= options.min_delta_white && comparison.delta_bic > options.minimum_delta_bic &&
         (comparison.t > options.minimum_t ||
          (comparison.delta_bic > options.strong_delta_bic && comparison.t > options.minimum_t_strong));
}

double samples_of(const std::vector<std::vector<double>>& blocks) {
  return std::accumulate(blocks.begin(), blocks.end(), 0.0,
                         [](double sum, const auto& block) { return sum + static_cast<double>(block.size()); });
}

double lagged_product(const std::vector<std::vector<double>>& blocks, std::size_t lag) {
  double product = 0.0;
  for (const std::vector<double>& block : blocks) {
    const auto from = block.begin() + static_cast<std::ptrdiff_t>(std::min(lag, block.size()));
    product = std::inner_product(from, block.end(), block.begin(), product);
  }
  return product;
}

double effective_sample_size(const std::vector<std::vector<double>>& blocks) {
  const double samples = samples_of(blocks);
  const double power = lagged_product(blocks, 0);
  if (!(power > 0.0)) {
    return samples;
  }
  double time = 1.0;
  double product = 0.0;
  for (std::size_t lag = 1; (product = lagged_product(blocks, lag)) > 0.0; ++lag) {
    time += 2.0 * product / power;
  }
  return std::max(1.0, samples / time);
}

double whitened_criterion(const std::vector<std::vector<double>>& without, const std::vector<std::vector<double>>& with,
                          std::size_t extra) {
  constexpr std::ptrdiff_t kThin = 5;
  constexpr double kRegularisation = 0.25e-6;  // a millionth of the power
  std::vector<Segment> segments;
  const auto means_of = [&](const std::vector<std::vector<double>>& blocks) {
    segments.clear();
    std::vector<double> means;
    for (const std::vector<double>& block : blocks) {
      const Eigen::Index begin = std::ssize(means);
      for (auto at = block.begin(); block.end() - at >= kThin; at += kThin) {
        means.push_back(std::accumulate(at, at + kThin, 0.0) / kThin);
      }
      segments.push_back({begin, std::ssize(means)});
    }
    return Rows(Eigen::Map<const Rows>(means.data(), std::ssize(means)));
  };
  Rows a = means_of(without);
  Rows b = means_of(with);
  const Ar filter = autoregression(b, segments, kRegularisation);
  whiten(filter, segments, a);
  whiten(filter, segments, b);
  const double count = whitened_rows(segments);
  if (!(count > 0.0 && a.squaredNorm() > 0.0 && b.squaredNorm() > 0.0)) {
    return 0.0;
  }
  return count * std::log(a.squaredNorm() / b.squaredNorm()) - static_cast<double>(extra) * std::log(count);
}

double information_criterion(double mean_square, double effective_samples, std::size_t parameters) {
  return effective_samples * std::log(std::max(mean_square, 1e-300)) +
         static_cast<double>(parameters) * std::log(std::max(effective_samples, 2.0));
}

std::vector<std::vector<double>> training_errors(const Family& family, const Fit& fit) {
  std::vector<std::vector<double>> out;
  for (const std::vector<double>& block : family.errors(fit, std::vector<int>(family.block_count(), 1))) {
    const std::ptrdiff_t length = std::ssize(block) / static_cast<std::ptrdiff_t>(family.axes());
    for (auto at = block.begin(); at != block.end(); at += length) {
      out.emplace_back(at, at + length);
    }
  }
  return out;
}

void cross_validate(const Family& family, CrossValidatedFit& out, std::size_t folds) {
  const std::size_t blocks = family.block_count();
  out.errors = training_errors(family, out.fit);
  out.effective_samples = effective_sample_size(out.errors);
  out.cv_block.assign(blocks, 0.0);
  const std::size_t used = std::min(folds, blocks);
  for (std::size_t fold = 0; fold < used; ++fold) {
    std::vector<int> kept(blocks, 1);
    std::vector<int> left_out(blocks, 0);
    for (std::size_t block = fold; block < blocks; block += used) {
      kept[block] = used > 1 ? 0 : 1;
      left_out[block] = 1;
    }
    const Fit fitted = family.fit(out.fit.structure, kept, &out.fit);
    const std::vector<std::vector<double>> errors = family.errors(fitted, left_out);
    for (std::size_t block = fold; block < blocks; block += used) {
      out.cv_block[block] = lagged_product({errors[block]}, 0);
    }
  }
  out.cv = std::accumulate(out.cv_block.begin(), out.cv_block.end(), 0.0);
}

CrossValidatedFit cross_validated_fit(const Family& family, const Structure& structure, const Fit* warm,
                                      std::size_t folds) {
  CrossValidatedFit out;
  out.fit = family.fit(structure, std::vector<int>(family.block_count(), 1), warm);
  cross_validate(family, out, folds);
  return out;
}

}  // namespace m100::lab::identify
