// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

namespace m100::lab::logs {

/// The times at which the samples of a stream were taken, recovered from arrivals that come several at a time.
struct SpreadArrivals {
  std::vector<double> time_s;  ///< one for each arrival; NaN where it is spoilt or far out of order
  double interval_s = 0.0;     ///< between consecutive counts
  double bunch_s = 0.0;        ///< between the bunches
  double delay_s = 0.0;        ///< 98 % of the arrivals are at most this much later than their time
  bool by_counter = false;     ///< by the counter; otherwise by the regular rate
};

/// Whether more than two in five intervals, without holes, are below a third of their mean; false below 32 arrivals.
/// Independent arrivals (Poisson) have 28 %, and a regular stream with a jitter below a third of its interval has none.
bool are_bunched(const std::vector<double>& arrival_s);

/// Places the samples on a line through the earliest arrivals, because a sample arrives late, but never before it was
/// taken. The stream is divided where the counter starts anew, where the clock was set or paused (stretches.h) and,
/// without a counter, at holes if one line does not fit.
/// All parts have the same least-squares slope.
/// @param counter  number of each message, empty if there is none. Holes in it are lost messages; wraps of 8, 16 and 32
///   bits are removed.
/// @returns nothing if there are fewer than 32 arrivals, if the rate is not constant, or if the times would decrease
///   within a stretch.
std::optional<SpreadArrivals> spread_arrivals(const std::vector<double>& arrival_s, const std::vector<double>& counter);

}  // namespace m100::lab::logs
