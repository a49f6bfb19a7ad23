// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/log_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <numbers>

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kWindow_s = 0.5;        // over which a stick's way is averaged: a shorter push moves little
constexpr double kAnswer_s = 1.0;        // within which every vehicle answers: delay and dynamics together
constexpr double kStillShare = 0.15;     // of the response's own large values; half a stick gives more
constexpr double kHeldShare = 0.5;       // of the stick's own large values
constexpr double kNoises = 8.0;          // of a rest's own standard deviations: no sample of an hour is farther off
constexpr double kAfterTakeOff_s = 1.0;  // ground effect, motors still spinning up

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) {
    return 0.0;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double large(const std::vector<double>& values) {
  std::vector<double> sizes(values.size());
  std::transform(values.begin(), values.end(), sizes.begin(), [](double v) { return std::abs(v); });
  return quantile(std::move(sizes), 0.98);
}

struct Pair {
  const std::vector<double>* stick;
  const std::vector<double>* response;
  double held;   ///< a stick that moves by more, and stays there, is answered in the air
  double still;  ///< a response that moves by less stands still
  bool tells;    ///< whether half a stick's answer would be seen above the noise
};

/// What a signal's own noise moves it by where it rests: the quietest twentieth of its windows.
double noise_of(const std::vector<double>& values, std::size_t window) {
  std::vector<double> sigmas;
  for (std::size_t begin = 0; window > 1 && begin + window <= values.size(); begin += window) {
    double mean = 0.0;
    double square = 0.0;
    for (std::size_t i = begin; i < begin + window; ++i) {
      mean += values[i] / static_cast<double>(window);
      square += values[i] * values[i] / static_cast<double>(window);
    }
    sigmas.push_back(std::sqrt(std::max(0.0, square - mean * mean)));
  }
  return quantile(std::move(sigmas), 0.05);
}

std::vector<Pair> pairs_of(const FlightLog& log, std::size_t window) {
  constexpr std::pair<Signal, Signal> kPairs[] = {
      {Signal::kStickRoll, Signal::kAttitudeRoll},     {Signal::kStickPitch, Signal::kAttitudePitch},
      {Signal::kStickThrottle, Signal::kVelocityZ},    {Signal::kCommandRoll, Signal::kAttitudeRoll},
      {Signal::kCommandPitch, Signal::kAttitudePitch}, {Signal::kCommandClimb, Signal::kVelocityZ}};
  std::vector<Pair> out;
  for (const auto& [stick, response] : kPairs) {
    if (log.has(stick) && log.has(response)) {
      const double most = large(log.of(response));
      const double still = std::max(kStillShare * most, kNoises * noise_of(log.of(response), window));
      const Pair pair{&log.of(stick), &log.of(response), kHeldShare * large(log.of(stick)), still,
                      still < 0.5 * kHeldShare * most};
      if (pair.held > 0.0 && pair.still > 0.0) {
        out.push_back(pair);
      }
    }
  }
  return out;
}

/// How far apart the means of a stick over a window have been.
class Travel {
 public:
  explicit Travel(std::size_t window) : window_(std::max<std::size_t>(1, window)) {}
  void add(double value) {
    last_.push_back(value);
    sum_ += value;
    if (last_.size() > window_) {
      sum_ -= last_.front();
      last_.pop_front();
    }
    if (last_.size() == window_) {
      highest_ = std::max(highest_, sum_ / static_cast<double>(window_));
      lowest_ = std::min(lowest_, sum_ / static_cast<double>(window_));
    }
  }
  double apart() const { return highest_ - lowest_; }

 private:
  std::size_t window_;
  std::deque<double> last_;
  double sum_ = 0.0;
  double highest_ = -1e300;
  double lowest_ = 1e300;
};

/// Length of the stretch from one end of the log on which every response stays where it was, and whether a stick went
/// from one place to another on it, long enough for an answer, in vain: one that is held from the log's end on may be
/// answered by what does not move. `sample(k)`: the k-th from that end.
template <typename Sample>
std::size_t still_from_end(const std::vector<Pair>& pairs, std::size_t size, double period_s, Sample&& sample) {
  const auto window = static_cast<std::size_t>(std::lround(kWindow_s / period_s));
  const auto answer = static_cast<std::size_t>(std::lround(kAnswer_s / period_s));
  std::vector<double> first(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    std::vector<double> begin;
    for (std::size_t k = 0; k < std::min(window, size); ++k) {
      begin.push_back((*pairs[p].response)[sample(k)]);
    }
    first[p] = quantile(std::move(begin), 0.5);
  }
  std::vector<Travel> travels(pairs.size(), Travel(window));
  std::size_t moved = size;  // sample from which on a stick's way asks for an answer
  std::size_t k = 0;
  for (; k < size; ++k) {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (std::abs((*pairs[p].response)[sample(k)] - first[p]) > pairs[p].still) {
        return k > moved + answer ? k : 0;
      }
      travels[p].add((*pairs[p].stick)[sample(k)]);
      moved = pairs[p].tells && travels[p].apart() > pairs[p].held ? std::min(moved, k) : moved;
    }
  }
  return 0;  // nothing ever moved: that is for others to say
}

}  // namespace

std::vector<std::pair<double, double>> ground_times(const FlightLog& log) {
  std::vector<std::pair<double, double>> out;
  const std::vector<Pair> pairs = pairs_of(log, static_cast<std::size_t>(std::lround(kWindow_s / log.period_s)));
  if (pairs.empty()) {
    return out;
  }
  std::vector<std::pair<std::size_t, std::size_t>> parts;
  for (const logs::Flight& flight : log.flights) {
    parts.emplace_back(flight.begin, flight.end);
  }
  if (parts.empty()) {
    parts.emplace_back(0, log.size);
  }
  for (const auto& part : parts) {
    const std::size_t first = part.first;
    const std::size_t end = part.second;
    const std::size_t count = end - first;
    const std::size_t before = still_from_end(pairs, count, log.period_s, [&](std::size_t k) { return first + k; });
    const std::size_t after = still_from_end(pairs, count, log.period_s, [&](std::size_t k) { return end - 1 - k; });
    if (before > 0) {
      out.emplace_back(log.time_s(first), log.time_s(first + before));
    }
    if (after > 0) {
      out.emplace_back(log.time_s(end - after), log.time_s(end));
    }
  }
  return out;
}

std::vector<Finding> ground_findings(const std::vector<std::pair<double, double>>& times) {
  std::vector<Finding> out;
  for (const auto& [from_s, to_s] : times) {
    char text[120];
    std::snprintf(text, sizeof text, "%.1f to %.1f s: on the ground, a held stick was not answered: kept out", from_s,
                  to_s);
    out.push_back({.what = "on_ground", .signal = "", .from_s = from_s, .to_s = to_s, .text = text});
  }
  return out;
}

void mask_unusable(const FlightLog& log, const std::vector<std::uint8_t>& gap,
                   const std::vector<std::pair<double, double>>& ground, double memory_s, std::vector<char>& valid) {
  const auto memory = static_cast<std::size_t>(std::lround(memory_s / log.period_s));
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < std::min(valid.size(), gap.size()); ++i) {
    unknown = gap[i] != 0 ? memory + 1 : unknown > 0 ? unknown - 1 : 0;
    valid[i] = unknown > 0 ? 0 : valid[i];
  }
  for (const auto& [from_s, to_s] : ground) {
    const std::size_t end = log.index_of(to_s + kAfterTakeOff_s);
    for (std::size_t i = log.index_of(from_s); i < std::min(end, valid.size()); ++i) {
      valid[i] = 0;
    }
  }
}

double hold_s(const std::vector<double>& values, const std::vector<char>& used, double period_s) {
  std::vector<double> runs;
  std::size_t since = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != values[i - 1] || used[i] == 0) {
      if (used[i] != 0) {
        runs.push_back(static_cast<double>(i - since));
      }
      since = i;
    }
  }
  return quantile(std::move(runs), 0.5) * period_s;
}

double cut_share(const std::vector<double>& stick, const std::vector<char>& used) {
  double low = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < stick.size(); ++i) {
    low = used[i] != 0 ? std::min(low, stick[i]) : low;
    high = used[i] != 0 ? std::max(high, stick[i]) : high;
  }
  const double slack = 0.005 * (high - low);
  if (!(std::abs(high + low) < 4.0 * slack)) {
    return 0.0;
  }
  std::size_t at_stop = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < stick.size(); ++i) {
    count += used[i] != 0 ? 1U : 0U;
    at_stop += used[i] != 0 && (stick[i] > high - slack || stick[i] < low + slack) ? 1U : 0U;
  }
  return static_cast<double>(at_stop) / static_cast<double>(std::max<std::size_t>(1, count));
}

std::vector<char> inside(const FlightLog& log, const std::vector<std::pair<double, double>>& ranges, double margin_s) {
  std::vector<char> out(log.size, ranges.empty() ? 1 : 0);
  for (const auto& [from_s, to_s] : ranges) {
    const std::size_t end = log.index_of(to_s + margin_s);
    for (std::size_t i = log.index_of(from_s - margin_s); i < end; ++i) {
      out[i] = 1;
    }
  }
  return out;
}

std::vector<Finding> repair_units(std::vector<double>& angle_rad, const std::vector<char>& used,
                                  const std::string& signal) {
  // Not the largest: one broken sample must not rescale a log.
  std::vector<double> sizes;
  for (std::size_t i = 0; i < angle_rad.size(); ++i) {
    if (used[i] != 0) {
      sizes.push_back(std::abs(angle_rad[i]));
    }
  }
  const double most = quantile(std::move(sizes), 0.995);
  if (!(most > 1.02 * std::numbers::pi)) {
    return {};
  }
  for (double& value : angle_rad) {
    value *= std::numbers::pi / 180.0;
  }
  return {{.what = "wrong_unit",
           .signal = signal,
           .text = signal + " goes to " + std::to_string(most) +
                   ", more than half a turn: taken for degrees (scale = 0.0174533 in the column map says so)"}};
}

namespace {

struct Found {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t samples = 0;
  void add(std::size_t from, std::size_t to) {
    first = samples == 0 ? from : first;
    last = to;
    samples += to - from;
  }
};

/// Lengths of the runs of equal used values, as [begin, end).
std::vector<std::pair<std::size_t, std::size_t>> equal_runs(const std::vector<double>& values,
                                                            const std::vector<char>& used) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= values.size(); ++i) {
    const bool goes_on = i < values.size() && used[i] != 0 && used[i - 1] != 0 && values[i] == values[i - 1];
    if (!goes_on) {
      if (used[i - 1] != 0) {
        out.emplace_back(begin, i);
      }
      begin = i;
    }
  }
  return out;
}

Found take_frozen_out(const std::vector<double>& values, std::vector<char>& used) {
  constexpr double kLeastRows = 5.0;
  constexpr double kCadences = 4.0;
  constexpr double kJump = 3.0;  // of the usual step from row to row
  const auto runs = equal_runs(values, used);
  std::vector<double> lengths;
  std::vector<double> steps;
  for (const auto& [begin, end] : runs) {
    lengths.push_back(static_cast<double>(end - begin));
    if (end < values.size() && used[end] != 0) {
      steps.push_back(std::abs(values[end] - values[begin]));
    }
  }
  const double least = std::max(kLeastRows, kCadences * quantile(std::move(lengths), 0.9));
  const double usual = quantile(std::move(steps), 0.5);
  Found out;
  for (const auto& [begin, end] : runs) {
    const bool jumps = end < values.size() && used[end] != 0 && std::abs(values[end] - values[begin]) > kJump * usual;
    if (static_cast<double>(end - begin) > least && jumps) {
      std::fill(used.begin() + static_cast<std::ptrdiff_t>(begin), used.begin() + static_cast<std::ptrdiff_t>(end),
                static_cast<char>(0));
      out.add(begin, end);
    }
  }
  return out;
}

Found replace_outliers(std::vector<double>& values, const std::vector<char>& used) {
  constexpr double kSigmas = 12.0;
  constexpr double kShare = 0.05;
  std::vector<double> bends;
  for (std::size_t i = 2; i < values.size(); ++i) {
    if (used[i] != 0 && used[i - 1] != 0 && used[i - 2] != 0) {
      bends.push_back(std::abs(values[i] - 2.0 * values[i - 1] + values[i - 2]));
    }
  }
  // A log that was resampled by straight lines bends at its own rows only: then the upper tenth says more.
  const double bend = std::max(1.4826 * quantile(bends, 0.5), quantile(bends, 0.9) / 1.645);
  const double sigma = bend / std::sqrt(6.0);
  const double least = std::max(kSigmas * sigma, kShare * large(values));
  Found out;
  const std::vector<double> old = values;
  for (std::size_t i = 2; i + 2 < values.size(); ++i) {
    std::array<double, 5> five{old[i - 2], old[i - 1], old[i], old[i + 1], old[i + 2]};
    std::nth_element(five.begin(), five.begin() + 2, five.end());
    // A sharp turn is foretold by straight lines from one of its sides.
    const double from_left = std::abs(old[i] - (2.0 * old[i - 1] - old[i - 2]));
    const double from_right = std::abs(old[i] - (2.0 * old[i + 1] - old[i + 2]));
    const double off = std::min({std::abs(old[i] - five[2]), from_left, from_right});
    if (used[i] != 0 && sigma > 0.0 && off > least) {
      values[i] = five[2];
      out.add(i, i + 1);
    }
  }
  return out;
}

}  // namespace

std::vector<Finding> repair_samples(std::vector<double>& values, std::vector<char>& used, const Clock& clock,
                                    const std::string& signal) {
  std::vector<Finding> out;
  const auto say = [&](const Found& found, const char* what, const std::string& text) {
    if (found.samples > 0) {
      out.push_back({.what = what,
                     .signal = signal,
                     .from_s = clock.start_s + clock.period_s * static_cast<double>(found.first),
                     .to_s = clock.start_s + clock.period_s * static_cast<double>(found.last),
                     .text = std::to_string(found.samples) + text});
    }
  };
  say(take_frozen_out(values, used), "frozen", " samples of " + signal + " repeat the one before: kept out");
  say(replace_outliers(values, used), "outliers", " samples of " + signal + " jump away and back: replaced");
  return out;
}

double share_explained(const std::vector<double>& stick, const std::vector<double>& response,
                       const std::vector<char>& used, double period_s) {
  constexpr double kLongest_s = 0.6;
  const auto longest = static_cast<std::size_t>(std::lround(kLongest_s / period_s));
  const std::size_t step = std::max<std::size_t>(1, longest / 12);
  double best = 0.0;
  for (std::size_t lag = 0; lag <= longest; lag += step) {
    double uu = 0.0;
    double yy = 0.0;
    double uy = 0.0;
    for (std::size_t i = lag; i < response.size(); ++i) {
      if (used[i] != 0) {
        uu += stick[i - lag] * stick[i - lag];
        yy += response[i] * response[i];
        uy += stick[i - lag] * response[i];
      }
    }
    best = std::max(best, uu > 0.0 && yy > 0.0 ? uy * uy / (uu * yy) : 0.0);
  }
  return best;
}

}  // namespace m100::lab::identify
