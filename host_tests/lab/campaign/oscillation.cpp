// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/oscillation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace m100::lab::campaign {
namespace {

// The trace has 100 points per second, of which every fifth is used. A period at 3 Hz is then 6.7 samples.
constexpr std::size_t kThin = 5;
constexpr double kSample_s = 0.01 * static_cast<double>(kThin);
constexpr auto kWindow = static_cast<std::size_t>(5.0 / kSample_s);
constexpr auto kHalfMean = static_cast<std::size_t>(1.0 / kSample_s);
constexpr std::size_t kStride = 5;  // windows begin every quarter of a second
constexpr auto kShortestLag = static_cast<std::size_t>(1.0 / 3.0 / kSample_s);
constexpr auto kLongestLag = static_cast<std::size_t>(1.0 / 0.3 / kSample_s);
constexpr double kRms_deg = 3.0;
constexpr double kCorrelation = 0.5;
constexpr double kHoverRms_deg = 2.0;
constexpr double kHoverFactor = 2.0;

std::vector<double> thinned_deg(const experiments::Trace& trace, const experiments::Trace& less,
                                double experiments::TracePoint::*tilt_rad) {
  std::vector<double> out;
  for (std::size_t i = 0; i < trace.size(); i += kThin) {
    out.push_back((trace[i].*tilt_rad - (i < less.size() ? less[i].*tilt_rad : 0.0)) * core::kRadian_deg);
  }
  return out;
}

/// Subtracts from each sample the mean of the two seconds around it (less at the ends).
std::vector<double> less_own_mean(const std::vector<double>& tilt) {
  std::vector<double> sum(tilt.size() + 1, 0.0);
  for (std::size_t i = 0; i < tilt.size(); ++i) {
    sum[i + 1] = sum[i] + tilt[i];
  }
  std::vector<double> out(tilt.size());
  for (std::size_t i = 0; i < tilt.size(); ++i) {
    const std::size_t from = i > kHalfMean ? i - kHalfMean : 0;
    const std::size_t to = std::min(tilt.size(), i + kHalfMean + 1);
    out[i] = tilt[i] - (sum[to] - sum[from]) / static_cast<double>(to - from);
  }
  return out;
}

double power(std::span<const double> x) {
  double sum = 0.0;
  for (const double value : x) {
    sum += value * value;
  }
  return sum;
}

/// Autocorrelation of the window at a lag in samples, normalised over the overlap.
double correlation(std::span<const double> x, std::size_t lag) {
  const std::size_t count = x.size() - lag;
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += x[i] * x[i + lag];
  }
  const double scale = std::sqrt(power(x.first(count)) * power(x.last(count)));
  return scale > 0.0 ? sum / scale : 0.0;
}

bool has_period(std::span<const double> window) {
  double before = correlation(window, kShortestLag - 1);
  double here = correlation(window, kShortestLag);
  for (std::size_t lag = kShortestLag; lag <= kLongestLag; ++lag) {
    const double behind = correlation(window, lag + 1);
    if (here > kCorrelation && here >= before && here >= behind) {
      return true;
    }
    before = here;
    here = behind;
  }
  return false;
}

bool is_periodic(const std::vector<double>& tilt) {
  const std::vector<double> deviation = less_own_mean(tilt);
  for (std::size_t from = 0; from + kWindow <= deviation.size(); from += kStride) {
    const std::span<const double> window(deviation.data() + from, kWindow);
    if (power(window) > kRms_deg * kRms_deg * static_cast<double>(kWindow) && has_period(window)) {
      return true;
    }
  }
  return false;
}

double deviation_deg(const std::vector<double>& tilt) {
  double mean = 0.0;
  for (const double value : tilt) {
    mean += value / static_cast<double>(tilt.size());
  }
  double sum = 0.0;
  for (const double value : tilt) {
    sum += (value - mean) * (value - mean);
  }
  return tilt.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(tilt.size()));
}

bool exceeds_reference(double flown_deg, double reference_deg) {
  return flown_deg > kHoverRms_deg && flown_deg > kHoverFactor * reference_deg;
}

}  // namespace

TiltOscillation measure_oscillation(const experiments::Trace& trace, const experiments::Trace& less) {
  const std::vector<double> roll = thinned_deg(trace, less, &experiments::TracePoint::roll_rad);
  const std::vector<double> pitch = thinned_deg(trace, less, &experiments::TracePoint::pitch_rad);
  return {.periodic = is_periodic(roll) || is_periodic(pitch),
          .roll_deviation_deg = deviation_deg(roll),
          .pitch_deviation_deg = deviation_deg(pitch)};
}

bool oscillates(const TiltOscillation& flown, const TiltOscillation& reference, bool hovers) {
  const bool periodic = flown.periodic && !reference.periodic;
  return periodic || (hovers && (exceeds_reference(flown.roll_deviation_deg, reference.roll_deviation_deg) ||
                                 exceeds_reference(flown.pitch_deviation_deg, reference.pitch_deviation_deg)));
}

bool is_surely_steady(const TiltOscillation& flown, bool hovers) {
  return !flown.periodic &&
         (!hovers || (flown.roll_deviation_deg <= kHoverRms_deg && flown.pitch_deviation_deg <= kHoverRms_deg));
}

}  // namespace m100::lab::campaign
