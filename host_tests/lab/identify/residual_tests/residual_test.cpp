// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/residual_test.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "firmware/core/eigen.h"
#include "host_tests/lab/identify/residual_tests/predictable_share.h"
#include "host_tests/lab/identify/residual_tests/vibration_and_drift.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

using Vector = Eigen::VectorXd;

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %"; }

constexpr double kMaxPiece_s = 120.0;    // longer pieces would need too many frequencies
constexpr double kLongestHole_s = 10.0;  // across a longer gap a peak would appear with many side peaks
constexpr double kHighest_hz = 4.0;      // of means at 10 Hz
constexpr double kPerBin = 2.0;          // frequencies per independent one: a peak between two keeps its power

/// One mean of the residual with its time.
struct Moment {
  std::size_t flight;
  double t_s;
  double value;
};

/// Consecutive moments [first, last) of one flight without a long gap.
struct Piece {
  std::size_t first;
  std::size_t last;
};

/// The means in order of time, whatever the order of training and validation ranges.
std::vector<Moment> moments_of(const Vector& target, const ResidualInput& input, const Thinned& thinned) {
  const double mean = target.mean();
  std::vector<Moment> out;
  for (std::size_t row = 0; row < thinned.begin.size(); ++row) {
    const std::size_t at = thinned.begin[row];
    out.push_back({at < input.flight.size() ? input.flight[at] : 0,
                   at < input.time_s.size() ? input.time_s[at] : input.sample_period_s * static_cast<double>(at),
                   target(static_cast<Eigen::Index>(row)) - mean});
  }
  std::sort(out.begin(), out.end(), [](const Moment& a, const Moment& b) {
    return a.flight != b.flight ? a.flight < b.flight : a.t_s < b.t_s;
  });
  return out;
}

/// Pieces in which an oscillation keeps its phase; a piece longer than 120 s is divided into equal ones.
std::vector<Piece> pieces_of(const std::vector<Moment>& moments) {
  std::vector<Piece> out;
  std::size_t first = 0;
  for (std::size_t k = 1; k <= moments.size(); ++k) {
    const bool goes_on = k < moments.size() && moments[k].flight == moments[first].flight &&
                         moments[k].t_s - moments[k - 1].t_s <= kLongestHole_s;
    if (goes_on) {
      continue;
    }
    const double span_s = moments[k - 1].t_s - moments[first].t_s;
    const double each_s = span_s / std::max(1.0, std::ceil(span_s / kMaxPiece_s));
    std::size_t begin = first;
    for (std::size_t i = first + 1; i < k; ++i) {
      if (moments[i].t_s - moments[begin].t_s > each_s) {
        out.push_back({begin, i});
        begin = i;
      }
    }
    out.push_back({begin, k});
    first = k;
  }
  return out;
}

/// Power of a piece at one frequency.
double power_at(const std::vector<Moment>& moments, const Piece& piece, double hz) {
  double c = 0.0;
  double s = 0.0;
  for (std::size_t k = piece.first; k < piece.last; ++k) {
    const double angle = 2.0 * std::numbers::pi * hz * (moments[k].t_s - moments[piece.first].t_s);
    c += moments[k].value * std::cos(angle);
    s += moments[k].value * std::sin(angle);
  }
  return 2.0 * (c * c + s * s) / static_cast<double>(piece.last - piece.first);
}

// Periodogram of the thinned residual by direct sums: a thousand frequencies, a few hundred samples per minute. A
// periodic force keeps its phase within a piece, and its power from piece to piece.
SpectralLine strongest_peak(const Vector& target, const ResidualInput& input, const Thinned& thinned) {
  const std::vector<Moment> moments = moments_of(target, input, thinned);
  const std::vector<Piece> pieces = pieces_of(moments);
  double span_s = 0.0;
  double total = 0.0;
  for (const Piece& piece : pieces) {
    span_s = std::max(span_s, moments[piece.last - 1].t_s - moments[piece.first].t_s);
  }
  for (const Moment& moment : moments) {
    total += moment.value * moment.value;
  }
  const double lowest_hz = 6.0 / span_s;  // fewer periods look like slow air
  const auto bins = static_cast<std::size_t>(kPerBin * kHighest_hz * span_s);
  std::vector<double> power(bins, 0.0);
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double hz = static_cast<double>(bin + 1) * kHighest_hz / static_cast<double>(bins);
    for (const Piece& piece : pieces) {
      power[bin] += power_at(moments, piece, hz);
    }
  }
  SpectralLine line;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double hz = static_cast<double>(bin + 1) * kHighest_hz / static_cast<double>(bins);
    if (hz >= lowest_hz && total > 0.0 && power[bin] / total > line.share) {
      line = {hz, power[bin] / total, height_of(power, bin, {.around = 32, .own = 7})};
    }
  }
  return line;
}

// Reports bursts, such as while commands are lost, that hold a large share of the residual's power.
void report_bursts(const Vector& target, const Vector& beyond, const Thinned& thinned,
                   const std::vector<double>& time_s, const ResidualOptions& options, std::vector<std::string>& out) {
  const Bursts bursts = bursts_of(target, beyond, options.burst_sigma);
  if (bursts.share > options.burst_share) {
    std::string text = "bursts (" + percent(bursts.share) + " of the power";
    const std::size_t at = thinned.begin[bursts.largest];
    if (at < time_s.size()) {
      text += printed(", the largest at %.1f s", time_s[at]);
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
    out.push_back(before + best.source + " (" + percent(best.predicted) + " of the residual; chance reaches " +
                  percent(std::max(0.0, best.shifted)) + ")");
  }
}

// The sizes of a residual minus the part that the uncertainty of the input explains, by least squares. At most the
// uncertainty itself is subtracted.
Vector subtract_uncertainty(const Vector& sizes, const Vector& input_uncertainty) {
  const Vector about = input_uncertainty.array() - input_uncertainty.mean();
  const double power = about.squaredNorm();
  const double slope = power > 0.0 ? about.dot(sizes) / power : 0.0;
  return sizes - std::clamp(slope, 0.0, 1.0) * input_uncertainty;
}

// Reports at most one spectral peak of the residuals, and one drift.
void report_peaks(const ResidualInput& input, const std::vector<Vector>& targets, const Thinned& thinned,
                  const ResidualOptions& options, ResidualFinding& finding) {
  const auto say = [&](const char* format, double a, double b = 0.0) {
    finding.unexplained.push_back(printed(format, a, b));
  };
  for (const std::vector<double>& residual : input.residuals) {
    const SpectralLine line = vibration_peak(residual, input.sample_period_s, input.row_s);
    if (line.share > options.periodic_share && line.peak > options.periodic_peak) {
      say("periodic %.1f Hz", line.hz);
      return;  // thinned, it would appear again under a false frequency
    }
  }
  for (const Vector& target : targets) {
    const SpectralLine line = strongest_peak(target, input, thinned);
    if (line.share > options.periodic_share && line.peak > options.periodic_peak) {
      say("periodic %.2f Hz", line.hz);
      break;
    }
  }
  for (const std::vector<double>& residual : input.residuals) {
    const Drift wander = drift(residual, input.block_begin, input.time_s);
    if (wander.share > options.drift_share && wander.t > options.drift_t) {
      say("drifts with time (%.0f %% of the residual, t %.1f)", 100.0 * wander.share, wander.t);
      break;
    }
  }
}

}  // namespace

void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more) {
  if (into.empty()) {
    into = std::move(more);
    return;
  }
  std::vector<RegressorGroup> both;
  for (RegressorGroup& group : into) {
    const auto same = std::find_if(more.begin(), more.end(), [&](const RegressorGroup& other) {
      return other.source == group.source && other.columns.size() == group.columns.size();
    });
    if (same == more.end()) {
      continue;
    }
    for (std::size_t k = 0; k < group.columns.size(); ++k) {
      std::vector<double>& column = group.columns[k];
      const std::vector<double> added = std::move(same->columns[k]);
      if (added.size() > column.size() / 4) {
        column.reserve(column.size() + added.size());  // a growing vector would take twice its size
      }
      column.insert(column.end(), added.begin(), added.end());
    }
    both.push_back(std::move(group));
  }
  into = std::move(both);
}

Bursts bursts_of(const Vector& values, const Vector& beyond, double sigmas) {
  constexpr double kPerMedian = 1.4826;
  Vector sizes = values.cwiseAbs();
  Eigen::Index largest = 0;
  sizes.maxCoeff(&largest);
  std::nth_element(sizes.begin(), sizes.begin() + sizes.size() / 2, sizes.end());
  const double sigma = kPerMedian * sizes(sizes.size() / 2);
  const double power = (beyond.array() > sigmas * sigma).select(beyond.array().square(), 0.0).sum();
  return {sigma > 0.0 ? power / values.squaredNorm() : 0.0, static_cast<std::size_t>(largest)};
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
    finding.unexplained.emplace_back("the residual was not tested: it has fewer than five stretches without a gap");
    return finding;
  }
  const Thinned thinned = thin(input, input.residuals.front().size());
  const Vector input_uncertainty = input.input_uncertainty.empty()
                                       ? Vector(Vector::Zero(static_cast<Eigen::Index>(thinned.begin.size())))
                                       : mean_of(input.input_uncertainty, thinned);
  std::vector<Vector> targets;
  std::vector<Vector> sizes;
  double square = 0.0;
  for (const std::vector<double>& residual : input.residuals) {
    targets.push_back(mean_of(residual, thinned));
    sizes.push_back(subtract_uncertainty(targets.back().cwiseAbs(), input_uncertainty));
    square += std::inner_product(residual.begin(), residual.end(), residual.begin(), 0.0) /
              static_cast<double>(residual.size());
  }
  finding.rms = std::sqrt(square / static_cast<double>(input.residuals.size()));

  finding.shares = predictable_shares(targets, input.groups, thinned, options.shifts);
  // A group must also predict the residual beyond the uncertainty of the input, which may correlate with the input.
  std::vector<std::string> known;
  if (input_uncertainty.squaredNorm() > 0.0) {
    std::vector<Vector> beyond;
    std::transform(targets.begin(), targets.end(), std::back_inserter(beyond), [&](const Vector& target) {
      return Vector(target.cwiseSign().cwiseProduct((target.cwiseAbs() - input_uncertainty).cwiseMax(0.0)));
    });
    report_best(predictable_shares(beyond, input.groups, thinned, options.shifts), options, "", known);
  }
  if (!known.empty() || !(input_uncertainty.squaredNorm() > 0.0)) {
    report_best(finding.shares, options, "predictable from ", finding.unexplained);
  }
  report_best(predictable_shares(sizes, input.activity, thinned, options.shifts), options, "grows with ",
              finding.unexplained);
  report_peaks(input, targets, thinned, options, finding);
  for (const Vector& target : targets) {
    const std::size_t before = finding.unexplained.size();
    report_bursts(target, (target.cwiseAbs() - input_uncertainty).cwiseMax(0.0), thinned, input.time_s, options,
                  finding.unexplained);
    if (finding.unexplained.size() > before) {
      break;
    }
  }
  if (input.noise_floor > 0.0 && finding.rms > options.floor_factor * input.noise_floor) {
    finding.unexplained.emplace_back("the residual is " + percent(finding.rms / input.noise_floor) +
                                     " of the declared noise floor");
  }
  return finding;
}

}  // namespace m100::lab::identify
