// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/alignment/rate_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace m100::lab::logs {
namespace {

constexpr double kRateEvidence = 0.8;  // least correlation of gyro and attitude rate to count as the same motion
constexpr double kLongestRateShift_s = 0.5;

template <typename Value>
void shift_later(std::vector<Value>& values, int samples) {
  const std::vector<Value> old = values;
  const auto last = static_cast<std::ptrdiff_t>(old.size()) - 1;
  for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(old.size()); ++k) {
    values[static_cast<std::size_t>(k)] =
        old[static_cast<std::size_t>(std::clamp(k - samples, std::ptrdiff_t{0}, last))];
  }
}

/// The lag d in samples at which b[k - d] matches a[k] best, by normalised cross-correlation of the mean-free signals
/// over |d| <= max_lag, and its correlation (peak). d > 0: b must be moved later.
struct Lag {
  int samples = 0;
  double peak = 0;
};

Lag best_lag(const std::vector<double>& a, const std::vector<double>& b, int max_lag) {
  const auto n = static_cast<std::ptrdiff_t>(std::min(a.size(), b.size()));
  const auto mean = [n](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.begin() + n, 0.0) / static_cast<double>(n);
  };
  const double mean_a = mean(a);
  const double mean_b = mean(b);
  Lag best;
  for (int d = -max_lag; d <= max_lag; ++d) {
    double ab = 0;
    double aa = 0;
    double bb = 0;
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, d); k < std::min(n, n + d); ++k) {
      const double x = a[static_cast<std::size_t>(k)] - mean_a;
      const double y = b[static_cast<std::size_t>(k - d)] - mean_b;
      ab += x * y;
      aa += x * x;
      bb += y * y;
    }
    const double correlation = aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
    if (correlation > best.peak) {
      best = {d, correlation};
    }
  }
  return best;
}

}  // namespace

void align_rates(FlightLog& log) {
  if (log.alignment.evidence != "none" || !log.has(Signal::kRateX) || !log.has(Signal::kAttitudeRoll)) {
    return;
  }
  const auto slope = [&log](Signal angle, std::size_t k) {
    const std::vector<double>& values = log.of(angle);
    return std::remainder(values[k + 1] - values[k - 1], 2.0 * std::numbers::pi) / (2.0 * log.period_s);
  };
  const bool turns = log.has(Signal::kAttitudePitch) && log.has(Signal::kAttitudeYaw);
  std::vector<double> turning(log.size, 0.0);
  for (std::size_t k = 0; log.size > 2 && k < log.size; ++k) {
    const std::size_t at = std::clamp<std::size_t>(k, 1, log.size - 2);
    turning[k] = slope(Signal::kAttitudeRoll, at) -
                 (turns ? std::sin(log.of(Signal::kAttitudePitch)[at]) * slope(Signal::kAttitudeYaw, at) : 0.0);
  }
  const Lag lag = best_lag(turning, log.of(Signal::kRateX), static_cast<int>(kLongestRateShift_s / log.period_s + 0.5));
  if (lag.peak < kRateEvidence) {
    return;
  }
  log.alignment.evidence = "correlation";
  if (lag.samples == 0) {
    return;
  }
  log.alignment.rate_shift_samples = lag.samples;
  log.notes.push_back("rate_x: is shifted by " + std::to_string(lag.samples) +
                      " samples against the attitude (correlation " + std::to_string(lag.peak) +
                      "); the rates were moved");
  for (int i = 0; i < 3; ++i) {
    const Signal rate = offset(Signal::kRateX, i);
    if (log.has(rate)) {
      shift_later(log.of(rate), lag.samples);
      log.signal_gap.contains(rate) ? shift_later(log.signal_gap.at(rate), lag.samples) : void();
    }
  }
}

}  // namespace m100::lab::logs
