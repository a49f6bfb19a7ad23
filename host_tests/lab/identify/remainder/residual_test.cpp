// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/remainder/residual_test.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "firmware/core/eigen.h"
#include "host_tests/lab/identify/remainder/residual_lines.h"
#include "host_tests/lab/identify/remainder/residual_share.h"

namespace m100::lab::identify {
namespace {

using Vector = Eigen::VectorXd;

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %"; }

struct Line {
  double hz = 0.0;
  double share = 0.0;
  double peak = 0.0;  // over the mean of its neighbourhood
};

// Periodogram over the thinned residual by plain sums: a few hundred frequencies, a few hundred samples per minute.
Line strongest_line(const Vector& target, const Thinned& thinned, double period_s) {
  const Eigen::Index rows = target.size();
  const double duration_s = period_s * static_cast<double>(thinned.end.back() - thinned.begin.front());
  const double lowest_hz = 6.0 / duration_s;  // fewer periods cannot be told from slow air
  const auto bins = std::min<std::size_t>(600, static_cast<std::size_t>(4.0 * duration_s));
  std::vector<double> power(bins, 0.0);
  const double mean = target.mean();
  const double total = (target.array() - mean).square().sum();
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double hz = static_cast<double>(bin + 1) * 4.0 / static_cast<double>(bins);
    double c = 0.0;
    double s = 0.0;
    for (Eigen::Index row = 0; row < rows; ++row) {
      const double t_s = period_s * static_cast<double>(thinned.begin[static_cast<std::size_t>(row)]);
      const double angle = 2.0 * std::numbers::pi * hz * t_s;
      c += (target(row) - mean) * std::cos(angle);
      s += (target(row) - mean) * std::sin(angle);
    }
    power[bin] = 2.0 * (c * c + s * s) / static_cast<double>(rows);
  }
  Line line;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double hz = static_cast<double>(bin + 1) * 4.0 / static_cast<double>(bins);
    if (hz < lowest_hz || total <= 0.0 || power[bin] / total <= line.share) {
      continue;
    }
    double around = 0.0;
    double count = 0.0;
    const std::size_t from = bin > 16 ? bin - 16 : 0;
    for (std::size_t other = from; other < std::min(bins, bin + 17); ++other) {
      if (other + 4 < bin + 1 || other > bin + 3) {
        around += power[other];
        count += 1.0;
      }
    }
    line = {hz, power[bin] / total, around > 0.0 ? power[bin] * count / around : 0.0};
  }
  return line;
}

// A coloured Gaussian residual stays within four robust sigmas; a command that was lost for a while does not.
void report_bursts(const Vector& target, const Thinned& thinned, const std::vector<double>& time_s,
                   const ResidualOptions& options, std::vector<std::string>& out) {
  std::vector<double> sizes(target.data(), target.data() + target.size());
  for (double& size : sizes) {
    size = std::abs(size);
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double sigma = 1.4826 * *middle;
  double burst = 0.0;
  Eigen::Index largest = 0;
  for (Eigen::Index row = 0; row < target.size(); ++row) {
    burst += std::abs(target(row)) > options.burst_sigma * sigma ? target(row) * target(row) : 0.0;
    largest = std::abs(target(row)) > std::abs(target(largest)) ? row : largest;
  }
  if (sigma > 0.0 && burst > options.burst_share * target.squaredNorm()) {
    std::string text = "bursts (" + percent(burst / target.squaredNorm()) + " of the power";
    const std::size_t at = thinned.begin[static_cast<std::size_t>(largest)];
    if (at < time_s.size()) {
      char where[48];
      std::snprintf(where, sizeof where, ", the largest at %.1f s", time_s[at]);
      text += where;
    }
    out.push_back(text + ")");
  }
}

void report_best(const std::vector<ResidualFinding::Share>& shares, const ResidualOptions& options,
                 const std::string& before, std::vector<std::string>& out) {
  if (shares.empty()) {
    return;
  }
  const ResidualFinding::Share& best = shares.front();
  if (best.predicted > options.minimum_share &&
      best.predicted > options.shift_factor * best.shifted + options.shift_margin) {
    out.push_back(before + best.source + " (" + percent(best.predicted) + " of what is left, chance reaches " +
                  percent(std::max(0.0, best.shifted)) + ")");
  }
}

// One line of the residuals, and one drift.
void report_lines(const ResidualInput& input, const std::vector<Vector>& targets, const Thinned& thinned,
                  const ResidualOptions& options, ResidualFinding& finding) {
  const auto say = [&](const char* format, double a, double b = 0.0) {
    char text[96];
    std::snprintf(text, sizeof text, format, a, b);
    finding.unexplained.emplace_back(text);
  };
  for (const std::vector<double>& residual : input.residuals) {
    const FastLine line = fast_line(residual, input.sample_period_s);
    if (line.share > options.periodic_share && line.peak > options.periodic_peak) {
      finding.line_hz = line.hz;
      finding.line_share = line.share;
      say("periodic %.1f Hz", line.hz);
      return;  // thinned, it would appear again under a false frequency
    }
  }
  for (const Vector& target : targets) {
    const Line line = strongest_line(target, thinned, input.sample_period_s);
    if (line.share > finding.line_share) {
      finding.line_hz = line.hz;
      finding.line_share = line.share;
    }
    if (line.share > options.periodic_share && line.peak > options.periodic_peak) {
      say("periodic %.2f Hz", line.hz);
      break;
    }
  }
  for (const std::vector<double>& residual : input.residuals) {
    const Drift wander = drift(residual, input.block_begin, input.time_s);
    if (wander.share > options.drift_share && wander.t > options.drift_t) {
      say("drifts with time (%.0f %% of what is left, t %.1f)", 100.0 * wander.share, wander.t);
      break;
    }
  }
}

}  // namespace

std::vector<std::vector<double>> lagged(const std::vector<double>& channel, const std::vector<std::size_t>& lags) {
  std::vector<std::vector<double>> out;
  for (const std::size_t lag : lags) {
    std::vector<double> column(channel.size());
    for (std::size_t i = 0; i < channel.size(); ++i) {
      column[i] = channel[i >= lag ? i - lag : 0];
    }
    out.push_back(std::move(column));
  }
  return out;
}

void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more) {
  if (into.empty()) {
    into = std::move(more);
    return;
  }
  for (std::size_t group = 0; group < std::min(into.size(), more.size()); ++group) {
    for (std::size_t k = 0; k < into[group].columns.size(); ++k) {
      std::vector<double>& column = into[group].columns[k];
      column.insert(column.end(), more[group].columns[k].begin(), more[group].columns[k].end());
    }
  }
}

double autocorrelation(const std::vector<double>& values, std::size_t lag, bool about_mean) {
  double mean = 0.0;
  for (const double value : values) {
    mean += about_mean ? value / static_cast<double>(values.size()) : 0.0;
  }
  double product = 0.0;
  double power = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    power += (values[k] - mean) * (values[k] - mean);
    product += k >= lag ? (values[k] - mean) * (values[k - lag] - mean) : 0.0;
  }
  return power > 0.0 ? product / power : 0.0;
}

ResidualFinding test_residual(const ResidualInput& input, const ResidualOptions& options) {
  ResidualFinding finding;
  if (input.residuals.empty() || input.residuals.front().empty() || input.block_begin.size() < kResidualFolds) {
    return finding;
  }
  const Thinned thinned = thin(input, input.residuals.front().size());
  std::vector<Vector> targets;
  std::vector<Vector> sizes;
  double square = 0.0;
  for (const std::vector<double>& residual : input.residuals) {
    targets.push_back(mean_of(residual, thinned));
    sizes.push_back(targets.back().cwiseAbs());
    square += std::inner_product(residual.begin(), residual.end(), residual.begin(), 0.0) /
              static_cast<double>(residual.size());
  }
  finding.rms = std::sqrt(square / static_cast<double>(input.residuals.size()));

  finding.shares = shares_of(targets, input.groups, thinned, options.shifts);
  report_best(finding.shares, options, "predictable from ", finding.unexplained);
  report_best(shares_of(sizes, input.activity, thinned, options.shifts), options, "grows with ", finding.unexplained);
  report_lines(input, targets, thinned, options, finding);
  for (const Vector& target : targets) {
    const std::size_t before = finding.unexplained.size();
    report_bursts(target, thinned, input.time_s, options, finding.unexplained);
    if (finding.unexplained.size() > before) {
      break;
    }
  }
  if (input.noise_floor > 0.0 && finding.rms > options.floor_factor * input.noise_floor) {
    finding.unexplained.emplace_back("disturbance " + percent(finding.rms / input.noise_floor) +
                                     " of the declared noise floor");
  }
  return finding;
}

}  // namespace m100::lab::identify
