// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/vibration_and_drift.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

namespace m100::lab::identify {
namespace {

constexpr double kPiece_s = 5.0;
constexpr double kSlowest_hz = 4.0;
constexpr double kFastestShare = 0.45;  // of the sample rate

/// Power of a piece in one of the bins of its Fourier transform, by Goertzel's recurrence.
double power_in(std::span<const double> piece, std::size_t bin) {
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(bin) / static_cast<double>(piece.size());
  const double twice = 2.0 * std::cos(angle);
  double newer = 0.0;
  double older = 0.0;
  for (const double value : piece) {
    const double next = value + twice * newer - older;
    older = newer;
    newer = next;
  }
  return 2.0 * (newer * newer + older * older - twice * newer * older) / static_cast<double>(piece.size());
}

}  // namespace

double height_of(const std::vector<double>& power, std::size_t bin, const Neighbourhood& place) {
  double around = 0.0;
  double count = 0.0;
  const std::size_t from = std::max(place.first, bin > place.around ? bin - place.around : 0);
  for (std::size_t other = from; other < std::min(power.size(), bin + place.around + 1); ++other) {
    if (other + place.own < bin || other > bin + place.own) {
      around += power[other];
      count += 1.0;
    }
  }
  return around > 0.0 ? power[bin] * count / around : 0.0;
}

SpectralLine vibration_peak(const std::vector<double>& residual, double period_s, double row_s) {
  SpectralLine line;
  const auto length = static_cast<std::size_t>(std::lround(kPiece_s / period_s));
  const double resolution_hz = 1.0 / (static_cast<double>(length) * period_s);
  const auto first = static_cast<std::size_t>(std::ceil(kSlowest_hz / resolution_hz));
  const auto last = static_cast<std::size_t>(kFastestShare / std::max(period_s, row_s) / resolution_hz);
  if (residual.size() < 2 * length || last <= first + 20) {
    return line;
  }
  std::vector<double> power(last + 1, 0.0);
  double total = 0.0;
  for (std::size_t begin = 0; begin + length <= residual.size(); begin += length) {
    const auto piece = std::span(residual).subspan(begin, length);
    total = std::inner_product(piece.begin(), piece.end(), piece.begin(), total);
    for (std::size_t bin = first; bin <= last; ++bin) {
      power[bin] += power_in(piece, bin);
    }
  }
  const auto strongest = static_cast<std::size_t>(
      std::max_element(power.begin() + static_cast<std::ptrdiff_t>(first), power.end()) - power.begin());
  // The power of a peak between two bins is spread over its neighbours.
  double held = 0.0;
  for (std::size_t bin = std::max(first, strongest - 1); bin <= std::min(last, strongest + 1); ++bin) {
    held += power[bin];
  }
  line.hz = static_cast<double>(strongest) * resolution_hz;
  line.share = total > 0.0 ? held / total : 0.0;
  line.peak = height_of(power, strongest, {.first = first, .around = 12, .own = 2});
  return line;
}

Drift drift(const std::vector<double>& residual, const std::vector<std::size_t>& block_begin,
            const std::vector<double>& time_s) {
  Drift out;
  if (time_s.size() != residual.size() || block_begin.size() < 6) {
    return out;
  }
  std::vector<double> mean(block_begin.size(), 0.0);
  std::vector<double> at(block_begin.size(), 0.0);
  const auto n = static_cast<double>(mean.size());
  double mean_of_all = 0.0;
  double middle_s = 0.0;
  for (std::size_t block = 0; block < mean.size(); ++block) {
    const std::size_t end = block + 1 < mean.size() ? block_begin[block + 1] : residual.size();
    const auto samples = static_cast<double>(end - block_begin[block]);
    for (std::size_t i = block_begin[block]; i < end; ++i) {
      mean[block] += residual[i] / samples;
      at[block] += time_s[i] / samples;
    }
    mean_of_all += mean[block] / n;
    middle_s += at[block] / n;
  }
  double xy = 0.0;
  double xx = 0.0;
  double yy = 0.0;
  for (std::size_t block = 0; block < mean.size(); ++block) {
    xy += (at[block] - middle_s) * (mean[block] - mean_of_all);
    xx += (at[block] - middle_s) * (at[block] - middle_s);
    yy += (mean[block] - mean_of_all) * (mean[block] - mean_of_all);
  }
  if (!(xx > 0.0 && yy > 0.0)) {
    return out;
  }
  const double r2 = std::min(1.0 - 1e-12, xy * xy / (xx * yy));
  // The share refers to the whole residual and not only to its means.
  double power = 0.0;
  for (const double value : residual) {
    power += value * value / static_cast<double>(residual.size());
  }
  out.share = power > 0.0 ? std::min(1.0, r2 * yy / n / power) : 0.0;
  out.t = std::sqrt(r2 * (n - 2.0) / (1.0 - r2));
  return out;
}

}  // namespace m100::lab::identify
