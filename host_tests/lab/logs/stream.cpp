// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/stream.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::lab::logs {
namespace {

constexpr double kGapFloor_s = 0.05;   // a stream of 100 Hz may lose four samples in a row without a gap
constexpr double kGapIntervals = 3.5;  // for slower streams: in their own intervals

enum class ClockState { kRuns, kStands, kSpoilt, kBackwards };

/// Judges the clock of row k after the rows taken so far. A single row out of order with both neighbours is spoilt.
ClockState clock_at(const Stream& stream, std::size_t k, const std::vector<double>& taken_s) {
  const double t = stream.time_s[k];
  if (!std::isfinite(t) || !std::isfinite(stream.values[k])) {
    return ClockState::kSpoilt;
  }
  if (taken_s.empty()) {
    return ClockState::kRuns;
  }
  const double last = taken_s.back();
  const bool has_next = k + 1 < stream.time_s.size();
  const double next = has_next ? stream.time_s[k + 1] : t;
  if (t == last) {
    return ClockState::kStands;
  }
  const bool one_back = t < last && (!has_next || next > last);
  const bool one_ahead = has_next && t > next && next > last;
  if (one_back || one_ahead) {
    return ClockState::kSpoilt;
  }
  return t < last ? ClockState::kBackwards : ClockState::kRuns;
}

}  // namespace

std::vector<double> unwrapped(std::vector<double> counter) {
  double turns = 0;
  for (std::size_t k = 1; k < counter.size(); ++k) {
    const double step = counter[k] + turns - counter[k - 1];
    turns += step < -32768.0 ? 65536.0 : 0.0;
    counter[k] += turns;
  }
  return counter;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void unwrap_angle(std::vector<double>& angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (std::size_t k = 1; k < angle.size(); ++k) {
    angle[k] -= kTurn * std::round((angle[k] - angle[k - 1]) / kTurn);
  }
}

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at, std::size_t& hint) {
  while (hint + 2 < x.size() && x[hint + 1] <= at) {
    ++hint;
  }
  const double span = x[hint + 1] - x[hint];
  return y[hint] + (y[hint + 1] - y[hint]) * (at - x[hint]) / span;
}

Stream without_defects(const Stream& stream, StreamDefects& untidy, std::size_t& backwards) {
  Stream tidy;
  bool spoilt = false;
  backwards = stream.time_s.size();
  for (std::size_t k = 0; k < stream.time_s.size(); ++k) {
    const ClockState clock = clock_at(stream, k, tidy.time_s);
    if (clock == ClockState::kBackwards) {
      backwards = k;
      return tidy;
    }
    spoilt = spoilt || clock == ClockState::kSpoilt;
    untidy.spoilt += clock == ClockState::kSpoilt ? 1 : 0;
    untidy.repeated += clock == ClockState::kStands ? 1 : 0;
    if (clock != ClockState::kRuns) {
      continue;
    }
    tidy.time_s.push_back(stream.time_s[k]);
    tidy.values.push_back(stream.values[k]);
    tidy.after_spoilt.push_back(spoilt ? 1 : 0);
    spoilt = false;
  }
  return tidy;
}

std::vector<double> resampled(const Stream& tidy, double start_s, double period_s, std::size_t size,
                              std::vector<std::uint8_t>& gap) {
  if (tidy.values.size() < 2) {
    std::fill(gap.begin(), gap.end(), std::uint8_t{1});
    return std::vector<double>(size, tidy.values.empty() ? 0.0 : tidy.values.front());
  }
  std::vector<double> interval(tidy.time_s.size() - 1);
  for (std::size_t k = 0; k < interval.size(); ++k) {
    interval[k] = tidy.time_s[k + 1] - tidy.time_s[k];
  }
  const double longest = std::max(kGapFloor_s, kGapIntervals * median(interval));
  const double slack = 1e-6 * period_s;
  std::vector<double> grid(size);
  std::size_t hint = 0;
  for (std::size_t k = 0; k < size; ++k) {
    const double wanted = start_s + static_cast<double>(k) * period_s;
    const double at = std::clamp(wanted, tidy.time_s.front(), tidy.time_s.back());
    grid[k] = interpolate(tidy.time_s, tidy.values, at, hint);
    const bool hole = interval[hint] > longest || tidy.after_spoilt[hint + 1] != 0;
    const bool inside = at > tidy.time_s[hint] + slack && at < tidy.time_s[hint + 1] - slack;
    if ((hole && inside) || std::abs(at - wanted) > period_s) {
      gap[k] = 1;
    }
  }
  return grid;
}

std::vector<double> period_means(const Stream& tidy, double start_s, double period_s, std::size_t size) {
  constexpr int kParts = 8;
  std::vector<double> out(size);
  std::size_t hint = 0;
  for (std::size_t k = 0; k < size; ++k) {
    double sum = 0.0;
    for (int part = 0; part < kParts; ++part) {
      const double at_s = start_s + (static_cast<double>(k) + (part + 0.5) / kParts) * period_s;
      sum += interpolate(tidy.time_s, tidy.values, std::clamp(at_s, tidy.time_s.front(), tidy.time_s.back()), hint);
    }
    out[k] = sum / kParts;
  }
  return out;
}

}  // namespace m100::lab::logs
