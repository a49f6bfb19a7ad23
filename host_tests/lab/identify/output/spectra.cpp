// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/spectra.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "host_tests/lab/statistics.h"

namespace m100::lab::identify {
namespace {

using Complex = std::complex<double>;

/// Fourier transform in place, radix two, decimation in time. Precondition: a power of two of values.
void transform(std::vector<Complex>& values) {
  const std::size_t n = values.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; (j & bit) != 0; bit >>= 1) {
      j ^= bit;
    }
    j ^= bit;
    if (i < j) {
      std::swap(values[i], values[j]);
    }
  }
  for (std::size_t size = 2; size <= n; size *= 2) {
    for (std::size_t k = 0; k < size / 2; ++k) {
      const Complex turn =
          std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(size));
      for (std::size_t at = k; at < n; at += size) {
        const Complex odd = turn * values[at + size / 2];
        values[at + size / 2] = values[at] - odd;
        values[at] += odd;
      }
    }
  }
}

/// Fourier transform of a segment minus its mean, under a Hann window.
std::vector<Complex> windowed(const std::vector<double>& values, std::size_t begin, std::size_t length) {
  const auto from = values.begin() + static_cast<std::ptrdiff_t>(begin);
  const double n = static_cast<double>(length);
  const double mean = std::accumulate(from, from + static_cast<std::ptrdiff_t>(length), 0.0) / n;
  std::vector<Complex> out(length);
  for (std::size_t i = 0; i < length; ++i) {
    const double window = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / n);
    out[i] = window * (values[begin + i] - mean);
  }
  transform(out);
  return out;
}

/// Covariance of a[k] and b[k + lag]: the sum over the pairs within a stretch, divided by the length of the series.
double product(const std::vector<double>& a, const std::vector<double>& b, std::ptrdiff_t lag,
               const std::vector<std::pair<std::size_t, std::size_t>>& stretches) {
  const double mean_a = mean_value(a);
  const double mean_b = mean_value(b);
  double sum = 0.0;
  for (const auto& [first, last] : stretches) {
    const auto begin = static_cast<std::ptrdiff_t>(first) + std::max<std::ptrdiff_t>(0, -lag);
    const auto end = static_cast<std::ptrdiff_t>(last) - std::max<std::ptrdiff_t>(0, lag);
    for (std::ptrdiff_t k = begin; k < end; ++k) {
      sum += (a[static_cast<std::size_t>(k)] - mean_a) * (b[static_cast<std::size_t>(k + lag)] - mean_b);
    }
  }
  return sum / std::max(1.0, static_cast<double>(a.size()));
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> stretches(const std::vector<double>& t_s, double sample_period_s) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    // A block of translation may begin half a sample period early, which is no gap.
    const bool goes_on = i > 0 && std::abs(t_s[i] - t_s[i - 1] - sample_period_s) < 0.6 * sample_period_s;
    if (!goes_on) {
      out.emplace_back(i, i);
    }
    out.back().second = i + 1;
  }
  return out;
}

double Spectra::coherence(std::size_t k) const {
  const double power = input[k] * output[k];
  return power > 0.0 ? std::min(1.0, std::norm(cross[k]) / power) : 0.0;
}

Spectra welch(const std::vector<double>& input, const std::vector<double>& output,
              const std::vector<std::pair<std::size_t, std::size_t>>& stretches, double sample_period_s) {
  constexpr double kSegment_s = 5.0;
  const auto power = std::max(3L, std::lround(std::log2(kSegment_s / sample_period_s)));
  const std::size_t length = std::size_t{1} << static_cast<unsigned>(power);
  const std::size_t bins = length / 2;
  Spectra out;
  out.input.assign(bins, 0.0);
  out.output.assign(bins, 0.0);
  out.cross.assign(bins, Complex{});
  for (const auto& [first, last] : stretches) {
    for (std::size_t begin = first; begin + length <= last; begin += length / 2) {
      const std::vector<Complex> x = windowed(input, begin, length);
      const std::vector<Complex> y = windowed(output, begin, length);
      for (std::size_t k = 0; k < bins; ++k) {
        out.input[k] += std::norm(x[k + 1]);
        out.output[k] += std::norm(y[k + 1]);
        out.cross[k] += std::conj(x[k + 1]) * y[k + 1];
      }
      ++out.segments;
    }
  }
  if (out.segments == 0) {
    return {};
  }
  constexpr double kHannPower = 0.375;
  const double scale =
      2.0 * sample_period_s / (kHannPower * static_cast<double>(length) * static_cast<double>(out.segments));
  for (std::size_t k = 0; k < bins; ++k) {
    out.frequency_hz.push_back(static_cast<double>(k + 1) / (static_cast<double>(length) * sample_period_s));
    out.input[k] *= scale;
    out.output[k] *= scale;
    out.cross[k] *= scale;
  }
  return out;
}

double cross_correlation(const std::vector<double>& earlier, const std::vector<double>& later, std::ptrdiff_t lag,
                         const std::vector<std::pair<std::size_t, std::size_t>>& stretches) {
  const double power = product(earlier, earlier, 0, stretches) * product(later, later, 0, stretches);
  return power > 0.0 ? product(earlier, later, lag, stretches) / std::sqrt(power) : 0.0;
}

double independent_band(const std::vector<double>& a, const std::vector<double>& b, std::size_t longest,
                        const std::vector<std::pair<std::size_t, std::size_t>>& stretches) {
  double sum = 1.0;
  for (std::size_t lag = 1; lag <= longest; ++lag) {
    const auto by = static_cast<std::ptrdiff_t>(lag);
    sum += 2.0 * cross_correlation(a, a, by, stretches) * cross_correlation(b, b, by, stretches);
  }
  return 1.96 * std::sqrt(std::max(1.0, sum) / std::max(1.0, static_cast<double>(a.size())));
}

}  // namespace m100::lab::identify
