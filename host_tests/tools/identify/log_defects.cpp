// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/log_defects.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "host_tests/tools/input_error.h"

namespace m100::tools::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kWindow_s = 0.5;        // a response that is still for so long under a held stick does not answer
constexpr double kStillShare = 0.15;     // of the response's own large values; half a stick gives more
constexpr double kHeldShare = 0.5;       // of the stick's own large values
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
  double held;
  double still;
};

std::vector<Pair> pairs_of(const FlightLog& log) {
  constexpr std::pair<Signal, Signal> kPairs[] = {{Signal::kStickRoll, Signal::kAttitudeRoll},
                                                  {Signal::kStickPitch, Signal::kAttitudePitch},
                                                  {Signal::kStickThrottle, Signal::kVelocityZ}};
  std::vector<Pair> out;
  for (const auto& [stick, response] : kPairs) {
    if (log.has(stick) && log.has(response)) {
      const Pair pair{&log.of(stick), &log.of(response), kHeldShare * large(log.of(stick)),
                      kStillShare * large(log.of(response))};
      if (pair.held > 0.0 && pair.still > 0.0) {
        out.push_back(pair);
      }
    }
  }
  return out;
}

/// Length of the stretch from one end of the log on which every response stays where it was, and whether a stick was
/// held on it in vain. `sample(k)`: the k-th from that end.
template <typename Sample>
std::size_t still_from_end(const std::vector<Pair>& pairs, std::size_t size, std::size_t window, Sample&& sample) {
  std::vector<double> first(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    first[p] = (*pairs[p].response)[sample(0)];
  }
  std::vector<std::size_t> held(pairs.size(), 0);
  bool in_vain = false;
  std::size_t k = 0;
  for (; k < size; ++k) {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (std::abs((*pairs[p].response)[sample(k)] - first[p]) > pairs[p].still) {
        return in_vain ? k : 0;
      }
      held[p] = std::abs((*pairs[p].stick)[sample(k)]) > pairs[p].held ? held[p] + 1 : 0;
      in_vain = in_vain || held[p] > window;
    }
  }
  return 0;  // nothing ever moved: that is for others to say
}

}  // namespace

std::vector<std::pair<double, double>> ground_times(const FlightLog& log) {
  std::vector<std::pair<double, double>> out;
  const std::vector<Pair> pairs = pairs_of(log);
  if (pairs.empty()) {
    return out;
  }
  const auto window = static_cast<std::size_t>(std::lround(kWindow_s / log.period_s));
  const std::size_t before = still_from_end(pairs, log.size, window, [](std::size_t k) { return k; });
  const std::size_t after = still_from_end(pairs, log.size, window, [&](std::size_t k) { return log.size - 1 - k; });
  if (before > 0) {
    out.emplace_back(log.start_s, log.time_s(before));
  }
  if (after > 0) {
    out.emplace_back(log.time_s(log.size - after), log.time_s(log.size));
  }
  return out;
}

std::vector<std::string> ground_findings(const std::vector<std::pair<double, double>>& times) {
  std::vector<std::string> out;
  for (const auto& [from_s, to_s] : times) {
    char text[120];
    std::snprintf(text, sizeof text, "%.1f to %.1f s: on the ground, a held stick was not answered: kept out", from_s,
                  to_s);
    out.emplace_back(text);
  }
  return out;
}

void mask_unusable(const FlightLog& log, const std::vector<std::pair<double, double>>& ground, double memory_s,
                   std::vector<char>& valid) {
  const auto memory = static_cast<std::size_t>(std::lround(memory_s / log.period_s));
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < std::min(valid.size(), log.gap.size()); ++i) {
    unknown = log.gap[i] != 0 ? memory + 1 : unknown > 0 ? unknown - 1 : 0;
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

void check_units(const FlightLog& log) {
  for (const Signal signal : {Signal::kAttitudeRoll, Signal::kAttitudePitch}) {
    for (const double value : log.of(signal)) {
      if (std::abs(value) > 1.02 * std::numbers::pi) {
        throw InputError(log.file, 0, std::string(logs::name_of(signal)),
                         "goes to " + std::to_string(value) +
                             " rad, more than half a turn: is it in degrees? (scale = 0.0174533 in the column map)");
      }
    }
  }
}

}  // namespace m100::tools::identify
