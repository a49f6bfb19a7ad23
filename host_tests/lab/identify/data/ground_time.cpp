// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/ground_time.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kWindow_s = 0.5;     // averaging time of a stick: a shorter push moves little
constexpr double kAnswer_s = 1.0;     // every vehicle answers within this time: delay and dynamics together
constexpr double kStillShare = 0.15;  // of the response's own large values; half a stick gives more
constexpr double kHeldShare = 0.5;    // of the stick's own large values
constexpr double kNoises = 8.0;       // standard deviations at rest: no sample of an hour exceeds this

struct Pair {
  const std::vector<double>* stick;
  const std::vector<double>* response;
  double held;          ///< in the air, a stick that moves by more and stays there is answered
  double still;         ///< a response that moves by less is at rest
  bool is_informative;  ///< whether half of the response to `held` would exceed `still`
};

/// Noise of a signal at rest, from the quietest twentieth of its windows.
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
      const double maximum = large(log.of(response));
      const double still = std::max(kStillShare * maximum, kNoises * noise_of(log.of(response), window));
      const Pair pair{&log.of(stick), &log.of(response), kHeldShare * large(log.of(stick)), still,
                      still < 0.5 * kHeldShare * maximum};
      if (pair.held > 0.0 && pair.still > 0.0) {
        out.push_back(pair);
      }
    }
  }
  return out;
}

/// Largest difference between the window means of a stick.
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

/// The median of each response over the first `count` samples from an end.
template <typename Sample>
std::vector<double> resting_samples(const std::vector<Pair>& pairs, std::size_t count, Sample&& sample) {
  std::vector<double> first;
  for (const Pair& pair : pairs) {
    std::vector<double> begin;
    for (std::size_t k = 0; k < count; ++k) {
      begin.push_back((*pair.response)[sample(k)]);
    }
    first.push_back(quantile(std::move(begin), 0.5));
  }
  return first;
}

/// Number of samples at one end of a flight in which all responses are at rest. 0 if no stick moved far enough at least
/// kAnswer_s before the first response moved, or if no response ever moves.
/// @param sample  gives the index of the k-th sample from that end
template <typename Sample>
std::size_t still_from_end(const std::vector<Pair>& pairs, std::size_t size, double period_s, Sample&& sample) {
  const auto window = static_cast<std::size_t>(std::lround(kWindow_s / period_s));
  const auto answer = static_cast<std::size_t>(std::lround(kAnswer_s / period_s));
  const std::vector<double> first = resting_samples(pairs, std::min(window, size), sample);
  std::vector<Travel> travels(pairs.size(), Travel(window));
  std::size_t moved = size;  // first sample at which a stick has moved far enough to be answered
  std::size_t k = 0;
  for (; k < size; ++k) {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (std::abs((*pairs[p].response)[sample(k)] - first[p]) > pairs[p].still) {
        return k > moved + answer ? k : 0;
      }
      travels[p].add((*pairs[p].stick)[sample(k)]);
      moved = pairs[p].is_informative && travels[p].apart() > pairs[p].held ? std::min(moved, k) : moved;
    }
  }
  return 0;  // nothing ever moved; other checks report this
}

}  // namespace

std::vector<std::pair<double, double>> ground_times(const FlightLog& log) {
  std::vector<std::pair<double, double>> out;
  const std::vector<Pair> pairs = pairs_of(log, static_cast<std::size_t>(std::lround(kWindow_s / log.period_s)));
  if (pairs.empty()) {
    return out;
  }
  for (const logs::Flight& part : log.parts()) {
    const std::size_t first = part.begin, end = part.end, count = end - first;
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
    const std::string text =
        printed("%.1f to %.1f s: on the ground, no answer to a held stick: excluded", from_s, to_s);
    out.push_back({.what = "on_ground", .signal = "", .from_s = from_s, .to_s = to_s, .text = text});
  }
  return out;
}

}  // namespace m100::lab::identify
