// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/stretches.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

/// The hole from which on a stream pauses.
double longest_dropout(const std::vector<double>& time_s) {
  constexpr double kIntervals = 3.5;  // as for a gap
  std::vector<double> intervals;
  for (std::size_t k = 1; k < time_s.size(); ++k) {
    if (time_s[k] > time_s[k - 1]) {
      intervals.push_back(time_s[k] - time_s[k - 1]);
    }
  }
  return std::max(kLongestDropout_s, intervals.empty() ? 0.0 : kIntervals * median(std::move(intervals)));
}

}  // namespace

std::vector<Stretch> stretches_of(const std::vector<double>& time_s) {
  std::vector<std::size_t> finite;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    if (std::isfinite(time_s[k])) {
      finite.push_back(k);
    }
  }
  const double dropout_s = longest_dropout(time_s);
  std::vector<Stretch> out;
  for (std::size_t i = 0; i < finite.size(); ++i) {
    const double t = time_s[finite[i]];
    const double next = time_s[finite[std::min(i + 1, finite.size() - 1)]];
    const double last = out.empty() ? t : out.back().to_s;
    const bool is_ahead = t > next && next > last;
    const bool is_set_back = t < last && next <= last && next >= t && i + 1 < finite.size();
    if (is_ahead || (t < last && !is_set_back)) {
      continue;
    }
    if (out.empty() || is_set_back || t > last + dropout_s) {
      const Stretch before = out.empty() ? Stretch{.to_s = t - kPause_s} : out.back();
      out.push_back({.begin = finite[i],
                     .from_s = t,
                     .set_back = before.set_back + (is_set_back ? 1U : 0U),
                     .shift_s = out.empty() ? 0.0 : before.to_s + before.shift_s + kPause_s - t});
    }
    out.back().to_s = t;
    ++out.back().samples;
  }
  return out;
}

std::vector<Stretch> placed(const std::vector<Stretch>& own, std::size_t fewest, double period_s) {
  std::vector<Stretch> out;
  std::copy_if(own.begin(), own.end(), std::back_inserter(out),
               [&](const Stretch& one) { return one.samples >= fewest; });
  if (out.empty()) {
    out.push_back(own.empty() ? Stretch{} : own.front());
  }
  const double start_s = out.front().from_s;
  out.front().shift_s = 0.0;
  for (std::size_t i = 1; i < out.size(); ++i) {
    const double free_s = out[i - 1].to_s + out[i - 1].shift_s + kPause_s - start_s;
    out[i].shift_s = start_s + std::ceil(free_s / period_s) * period_s - out[i].from_s;
  }
  return out;
}

std::string list_of(const std::vector<Stretch>& stretches) {
  constexpr std::size_t kListed = 8;
  std::string out;
  for (std::size_t i = 0; i < std::min(kListed, stretches.size()); ++i) {
    out += printed("%s%.2f to %.2f s", i == 0 ? "" : ", ", stretches[i].from_s, stretches[i].to_s);
  }
  return stretches.size() > kListed ? out + ", ..." : out;
}

std::vector<double> continuous(const std::vector<double>& time_s, const std::vector<Stretch>& own,
                               const std::vector<Stretch>& log) {
  constexpr double kBeside_s = 0.5 * kPause_s;
  std::vector<double> out(time_s.size(), std::numeric_limits<double>::infinity());
  std::size_t at = 0;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    at += at + 1 < own.size() && own[at + 1].begin <= k ? 1U : 0U;
    const std::size_t set_back = own.empty() ? 0 : own[at].set_back;
    const auto in = std::lower_bound(log.begin(), log.end() - 1, time_s[k], [&](const Stretch& one, double t) {
      return std::pair(one.set_back, one.to_s + kBeside_s) < std::pair(set_back, t);
    });
    if (in->set_back == set_back && (in == log.begin() || time_s[k] >= in->from_s - kBeside_s)) {
      out[k] = time_s[k] + in->shift_s;
    }
  }
  return out;
}

}  // namespace m100::lab::logs
