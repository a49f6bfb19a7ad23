// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/alignment/bunched_arrivals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/logs/stretches.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kMinArrivals = 32;
constexpr double kShortInterval = 1.0 / 3.0;  // of the mean
constexpr double kShortShare = 0.4;           // between the 28 % of Poisson arrivals and the half of bunches of two
constexpr double kEarliest = 0.02;            // quantiles that a few stamps that are wrong cannot move
constexpr double kLatest = 0.98;
constexpr double kMaxDisorder_s = 0.05;  // a larger step back: the clock was set, or runs backwards
constexpr double kHoleBunches = 3.5;
constexpr double kMinHole_s = 0.05;
constexpr double kMaxBunch_s = 1.0;  // a stream that arrives more seldom is none of a flight log: longer ones are holes

/// The arrivals without single ones that are far out of order between ordered neighbours: NaN takes their place.
std::vector<double> without_outliers(std::vector<double> arrival_s) {
  for (std::size_t k = 1; k + 1 < arrival_s.size(); ++k) {
    const double before = arrival_s[k - 1];
    const double after = arrival_s[k + 1];
    const bool is_early = arrival_s[k] < before - kMaxDisorder_s;
    const bool is_late = arrival_s[k] > after + kMaxDisorder_s;
    if (before <= after + kMaxDisorder_s && (is_early || is_late)) {
      arrival_s[k] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return arrival_s;
}

/// Whether the clock was set, or the recorder paused, between two arrivals.
bool is_break(double last_s, double next_s) {
  return next_s < last_s - kMaxDisorder_s || next_s > last_s + kLongestDropout_s;
}

/// Intervals between finite arrivals of one stretch. Receivers on several threads may stamp neighbours in the wrong
/// order: such small steps back are intervals too.
std::vector<double> intervals_of(const std::vector<double>& arrival_s) {
  std::vector<double> out;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (const double t : arrival_s) {
    if (!std::isfinite(t)) {
      continue;
    }
    if (std::isfinite(last) && !is_break(last, t)) {
      out.push_back(t - last);
    }
    last = t;
  }
  return out;
}

/// Seconds between bunches: the median of the intervals that are longer than the mean, both without holes that are too
/// long for a bunch.
double bunch_interval(std::vector<double> intervals) {
  std::erase_if(intervals, [](double d) { return d > kMaxBunch_s; });
  const double mean = intervals.empty() ? kMaxBunch_s : mean_value(intervals);
  std::erase_if(intervals, [&](double d) { return d <= mean; });
  return intervals.empty() ? mean : median(std::move(intervals));
}

/// Removes the wraps of a counter of 8, 16 or 32 bits: steps back by more than three quarters of the range.
std::vector<double> without_wraps(std::vector<double> counter) {
  constexpr std::array kRanges{256.0, 65536.0, 4294967296.0};
  const double largest = *std::max_element(counter.begin(), counter.end());
  const auto range = std::find_if(kRanges.begin(), kRanges.end(), [&](double r) { return largest < r; });
  double added = 0.0;
  double last = counter.front();
  for (double& number : counter) {
    const bool wraps = range != kRanges.end() && number < last && number + *range - last < 0.25 * *range;
    last = number;
    added += wraps ? *range : 0.0;
    number += added;
  }
  return counter;
}

/// Arrivals [begin, end) that share one line.
struct ArrivalPart {
  std::size_t begin, end;
};

struct ArrivalLine {
  double slope = 0.0;
  std::vector<double> start;  ///< of each part, at count zero
  double delay_s = 0.0;       ///< of 98 % of the arrivals
};

ArrivalLine fit(const std::vector<double>& arrival_s, const std::vector<double>& number,
                const std::vector<ArrivalPart>& parts) {
  double both = 0.0;
  double own = 0.0;
  std::vector<std::array<double, 2>> means;
  for (const ArrivalPart& part : parts) {
    double n = 0.0;
    double t = 0.0;
    const auto size = static_cast<double>(part.end - part.begin);
    for (std::size_t k = part.begin; k < part.end; ++k) {
      n += number[k] / size;
      t += arrival_s[k] / size;
    }
    means.push_back({n, t});
    for (std::size_t k = part.begin; k < part.end; ++k) {
      both += (number[k] - n) * (arrival_s[k] - t);
      own += (number[k] - n) * (number[k] - n);
    }
  }
  ArrivalLine line{.slope = own > 0.0 ? both / own : 0.0, .start = {}, .delay_s = 0.0};
  std::vector<double> delays;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::vector<double> left;
    for (std::size_t k = parts[i].begin; k < parts[i].end; ++k) {
      left.push_back((arrival_s[k] - means[i][1]) - line.slope * (number[k] - means[i][0]));
    }
    const double earliest = quantile(left, kEarliest);
    line.start.push_back(means[i][1] + earliest - line.slope * means[i][0]);
    std::transform(left.begin(), left.end(), std::back_inserter(delays), [&](double r) { return r - earliest; });
  }
  line.delay_s = quantile(std::move(delays), kLatest);
  return line;
}

/// Divides the arrivals into parts; `breaks(k)` tells whether arrival k begins a new one.
template <typename Breaks>
std::vector<ArrivalPart> parts_of(std::size_t size, Breaks&& breaks) {
  std::vector<ArrivalPart> parts{{0, 1}};
  for (std::size_t k = 1; k < size; ++k) {
    if (breaks(k)) {
      parts.push_back({k, k});
    }
    parts.back().end = k + 1;
  }
  return parts;
}

}  // namespace

bool are_bunched(const std::vector<double>& arrival_s) {
  const std::vector<double> intervals = intervals_of(without_outliers(arrival_s));
  if (intervals.size() + 1 < kMinArrivals) {
    return false;
  }
  const double hole = std::max(kMinHole_s, kHoleBunches * bunch_interval(intervals));
  std::vector<double> without_holes;
  std::copy_if(intervals.begin(), intervals.end(), std::back_inserter(without_holes),
               [&](double d) { return d <= hole; });
  const double mean = without_holes.empty() ? 0.0 : mean_value(without_holes);
  const auto shorter =
      std::count_if(without_holes.begin(), without_holes.end(), [&](double d) { return d < kShortInterval * mean; });
  return static_cast<double>(shorter) > kShortShare * static_cast<double>(without_holes.size());
}

std::optional<SpreadArrivals> spread_arrivals(const std::vector<double>& arrival_s,
                                              const std::vector<double>& counter) {
  const bool counted = counter.size() == arrival_s.size();
  const std::vector<double> ordered = without_outliers(arrival_s);
  std::vector<std::size_t> index;
  std::vector<double> at;
  std::vector<double> number;
  for (std::size_t k = 0; k < arrival_s.size(); ++k) {
    if (std::isfinite(ordered[k]) && (!counted || std::isfinite(counter[k]))) {
      index.push_back(k);
      at.push_back(ordered[k]);
      number.push_back(counted ? counter[k] : static_cast<double>(index.size()));
    }
  }
  const std::vector<double> intervals = intervals_of(at);
  if (at.size() < kMinArrivals || intervals.empty()) {
    return std::nullopt;
  }
  number = without_wraps(std::move(number));
  SpreadArrivals out{.time_s = std::vector<double>(arrival_s.size(), std::numeric_limits<double>::quiet_NaN()),
                     .bunch_s = bunch_interval(intervals),
                     .by_counter = counted};
  const double hole = std::max(kMinHole_s, kHoleBunches * out.bunch_s);
  std::vector<ArrivalPart> parts =
      parts_of(at.size(), [&](std::size_t k) { return number[k] < number[k - 1] || is_break(at[k - 1], at[k]); });
  ArrivalLine line = fit(at, number, parts);
  const auto fits = [&] { return line.slope > 0.0 && line.delay_s <= 2.0 * (out.bunch_s + line.slope); };
  if (!fits() && !counted) {
    parts = parts_of(at.size(), [&](std::size_t k) { return at[k] - at[k - 1] > hole || is_break(at[k - 1], at[k]); });
    line = fit(at, number, parts);
  }
  if (!fits()) {
    return std::nullopt;
  }
  out.interval_s = line.slope;
  out.delay_s = line.delay_s;
  double last = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t begin = parts[i].begin;
    last = begin > 0 && is_break(at[begin - 1], at[begin]) ? -std::numeric_limits<double>::infinity() : last;
    for (std::size_t k = begin; k < parts[i].end; ++k) {
      const double t = line.start[i] + line.slope * number[k];
      if (t < last) {
        return std::nullopt;
      }
      out.time_s[index[k]] = t;
      last = t;
    }
  }
  return out;
}

}  // namespace m100::lab::logs
