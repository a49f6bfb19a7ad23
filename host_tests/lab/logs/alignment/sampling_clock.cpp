// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/alignment/sampling_clock.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/logs/alignment/bunched_arrivals.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

bool rows_repeat(const std::vector<double>& arrival_s, const std::vector<double>& values) {
  std::size_t repeated = 0;
  std::size_t equal = 0;
  for (std::size_t k = 1; k < std::min(arrival_s.size(), values.size()); ++k) {
    repeated += arrival_s[k] == arrival_s[k - 1] ? 1U : 0U;
    equal += arrival_s[k] == arrival_s[k - 1] && values[k] == values[k - 1] ? 1U : 0U;
  }
  return 2 * equal > repeated;
}

/// Whether two clocks are equal; a NaN equals a NaN.
bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return x == y || (std::isnan(x) && std::isnan(y));
         });
}

std::string note_of(const std::string& stream, const SpreadArrivals& spread) {
  const double per_bunch = spread.bunch_s / spread.interval_s;
  const char* const how = spread.by_counter ? "their counter" : "their regular rate, because they have no counter";
  const double sure_s = spread.by_counter ? spread.interval_s : spread.bunch_s;
  return stream +
         printed(
             ": the samples arrive about %.2g at a time, every %.0f ms; they were spread by %s to %.2f Hz (arrivals up "
             "to %.0f ms late; the times are certain to %.0f ms)",
             per_bunch, 1e3 * spread.bunch_s, how, 1.0 / spread.interval_s, 1e3 * spread.delay_s, 1e3 * sure_s);
}

}  // namespace

std::vector<double> SamplingClock::times(const std::string& stream, const std::vector<double>& arrival_s,
                                         const std::vector<double>& counter, const std::vector<double>& values) {
  const auto known =
      std::find_if(known_.begin(), known_.end(), [&](const Known& one) { return same(one.arrival_s, arrival_s); });
  if (known != known_.end()) {
    return known->time_s;
  }
  std::vector<double> time_s = arrival_s;
  if (are_bunched(arrival_s) && (!counter.empty() || !rows_repeat(arrival_s, values))) {
    std::optional<SpreadArrivals> spread = spread_arrivals(arrival_s, counter);
    if (!spread && !counter.empty()) {
      spread = spread_arrivals(arrival_s, {});
    }
    notes_.push_back(spread ? note_of(stream, *spread)
                            : stream +
                                  ": the samples arrive in bunches at no constant rate; their times stay those of "
                                  "their arrival");
    time_s = spread ? std::move(spread->time_s) : std::move(time_s);
  }
  known_.push_back({arrival_s, std::move(time_s)});
  return known_.back().time_s;
}

}  // namespace m100::lab::logs
