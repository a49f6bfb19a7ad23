// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/residual_test.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>

#include "firmware/core/eigen.h"
#include "host_tests/tools/identify/residual_lines.h"
// After our eigen.h, which redirects the checks.
#include <Eigen/Cholesky>

namespace m100::tools::identify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kWorkRate_hz = 10.0;  // the residual has little above 5 Hz; averaging to this rate saves time
constexpr std::size_t kFolds = 5;
constexpr double kRidge = 0.02;  // of a column's own power: prior share of the signal that is noise

/// Means over `factor` samples, block by block, so that no mean straddles a block.
struct Thinned {
  std::vector<std::size_t> begin;  // first sample of each mean
  std::vector<std::size_t> end;
  std::vector<std::size_t> fold;
};

Thinned thin(const ResidualInput& input, std::size_t samples) {
  const auto factor =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(1.0 / (kWorkRate_hz * input.sample_period_s))));
  Thinned out;
  for (std::size_t block = 0; block < input.block_begin.size(); ++block) {
    const std::size_t stop = block + 1 < input.block_begin.size() ? input.block_begin[block + 1] : samples;
    for (std::size_t at = input.block_begin[block]; at < stop; at += factor) {
      out.begin.push_back(at);
      out.end.push_back(std::min(at + factor, stop));
      out.fold.push_back(block % kFolds);
    }
  }
  return out;
}

Vector mean_of(const std::vector<double>& values, const Thinned& thinned) {
  Vector out(static_cast<Eigen::Index>(thinned.begin.size()));
  for (std::size_t row = 0; row < thinned.begin.size(); ++row) {
    double sum = 0.0;
    for (std::size_t i = thinned.begin[row]; i < thinned.end[row]; ++i) {
      sum += values[i];
    }
    out(static_cast<Eigen::Index>(row)) = sum / static_cast<double>(thinned.end[row] - thinned.begin[row]);
  }
  return out;
}

/// Ridge regression of many targets on one group, cross-validated; normal equations are made once per fold.
class GroupRegression {
 public:
  GroupRegression(const RegressorGroup& group, const Thinned& thinned) : fold_(thinned.fold) {
    const auto rows = static_cast<Eigen::Index>(thinned.begin.size());
    x_.resize(rows, static_cast<Eigen::Index>(group.columns.size()) + 1);
    x_.col(0).setOnes();
    for (std::size_t k = 0; k < group.columns.size(); ++k) {
      Vector column = mean_of(group.columns[k], thinned);
      const double mean = column.mean();
      column.array() -= mean;
      const double size = std::sqrt(column.squaredNorm() / static_cast<double>(rows));
      x_.col(static_cast<Eigen::Index>(k) + 1) = size > 0.0 ? Vector(column / size) : Vector(Vector::Zero(rows));
    }
    const Matrix all = x_.transpose() * x_;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      Matrix kept = all;
      for (Eigen::Index row = 0; row < rows; ++row) {
        if (fold_[static_cast<std::size_t>(row)] == fold) {
          kept.selfadjointView<Eigen::Lower>().rankUpdate(x_.row(row).transpose(), -1.0);
        }
      }
      kept.triangularView<Eigen::StrictlyUpper>() = kept.transpose();
      for (Eigen::Index k = 1; k < kept.rows(); ++k) {
        kept(k, k) += kRidge * static_cast<double>(rows);
      }
      kept(0, 0) += 1e-9 * static_cast<double>(rows);
      solvers_.emplace_back(kept);
    }
  }

  /// Share of the target's variance that the other folds predict.
  double share(const Vector& target) const {
    const Vector all = x_.transpose() * target;
    std::vector<Vector> left_out(kFolds, Vector::Zero(x_.cols()));
    for (Eigen::Index row = 0; row < x_.rows(); ++row) {
      left_out[fold_[static_cast<std::size_t>(row)]] += x_.row(row).transpose() * target(row);
    }
    std::vector<Vector> weights;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      weights.push_back(solvers_[fold].solve(all - left_out[fold]));
    }
    double error = 0.0;
    for (Eigen::Index row = 0; row < x_.rows(); ++row) {
      const double offset = target(row) - x_.row(row).dot(weights[fold_[static_cast<std::size_t>(row)]]);
      error += offset * offset;
    }
    const double mean = target.mean();
    const double spread = (target.array() - mean).square().sum();
    return spread > 0.0 ? 1.0 - error / spread : 0.0;
  }

 private:
  Matrix x_;
  std::vector<std::size_t> fold_;
  std::vector<Eigen::LDLT<Matrix>> solvers_;
};

Vector shifted(const Vector& values, Eigen::Index by) {
  Vector out(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    out((i + by) % values.size()) = values(i);
  }
  return out;
}

// Best of all groups and directions on shifted targets is what chance reaches: one bar for all, so that asking many
// groups does not raise the rate of false alarms.
std::vector<ResidualFinding::Share> shares_of(const std::vector<Vector>& targets,
                                              const std::vector<RegressorGroup>& groups, const Thinned& thinned,
                                              std::size_t shifts) {
  std::vector<ResidualFinding::Share> out;
  double bar = 0.0;
  const auto rows = static_cast<Eigen::Index>(thinned.begin.size());
  const Eigen::Index least = std::max<Eigen::Index>(1, std::min<Eigen::Index>(rows / 4, 25));
  for (const RegressorGroup& group : groups) {
    const GroupRegression regression(group, thinned);
    ResidualFinding::Share share{group.source, -1.0, 0.0};
    for (const Vector& target : targets) {
      share.predicted = std::max(share.predicted, regression.share(target));
    }
    std::mt19937_64 random(20260101);  // the same shifts for every group
    for (std::size_t shift = 0; shift < shifts; ++shift) {
      const auto span = static_cast<std::uint64_t>(std::max<Eigen::Index>(1, rows - 2 * least));
      const Eigen::Index by = least + static_cast<Eigen::Index>(random() % span);
      for (const Vector& target : targets) {
        bar = std::max(bar, regression.share(shifted(target, by)));
      }
    }
    out.push_back(share);
  }
  for (ResidualFinding::Share& share : out) {
    share.shifted = bar;
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.predicted > b.predicted; });
  return out;
}

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

ResidualFinding test_residual(const ResidualInput& input, const ResidualOptions& options) {
  ResidualFinding finding;
  if (input.residuals.empty() || input.residuals.front().empty() || input.block_begin.size() < kFolds) {
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

}  // namespace m100::tools::identify
