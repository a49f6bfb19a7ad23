// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab {

/// 97.5 % quantile of Student's t (Abramowitz and Stegun 26.7.5): exact to 1 % from three degrees of freedom on.
inline double student_t(double degrees) {
  return 1.959964 + (2.3723 + (2.8225 + 2.5559 / degrees) / degrees) / degrees;
}

/// A number and its 95 % interval. Both ends are NaN where too few values were measured for an interval.
struct Interval {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// The mean with its interval by Student's t.
inline Interval mean_with_interval(const std::vector<double>& values) {
  const double mean = mean_value(values);
  double squares = 0.0;
  for (const double value : values) {
    squares += (value - mean) * (value - mean);
  }
  const auto n = static_cast<double>(values.size());
  const double half_width =
      n > 1.0 ? student_t(n - 1.0) * std::sqrt(squares / (n - 1.0) / n) : std::numeric_limits<double>::quiet_NaN();
  return {mean, mean - half_width, mean + half_width};
}

/// With fewer pairs the interval depends on the luck of two to four values: Student's t is 3.2 for four pairs, and it
/// assumes that they are normally distributed.
inline constexpr int kMinPairs = 5;
/// Share of the error before. A smaller change is no difference to a pilot: 0.5 mm of a hover's 10 mm.
inline constexpr double kNoDifference = 0.05;

/// The errors of flights of one course before and after a change, in pairs that share the seed or the place in the
/// series.
struct PairedErrors {
  int flights = 0;  ///< number of pairs
  double before_m = 0.0;
  double after_m = 0.0;
  /// After minus before: the mean over the pairs; of one pair, with the spread inside the two flights.
  Interval difference_m;

  /// The one rule by which a change in flight is judged, in the words of paired_rule().
  const char* verdict() const {
    const double no_difference_m = kNoDifference * before_m;
    return flights < kMinPairs || !std::isfinite(difference_m.low)             ? "cannot tell"
           : std::max(-difference_m.low, difference_m.high) <= no_difference_m ? "no difference"
           : difference_m.high < 0.0                                           ? "better"
           : difference_m.low > 0.0                                            ? "worse"
                                                                               : "cannot tell";
  }
  bool is_worse() const { return std::string(verdict()) == "worse"; }
};

/// The rule of PairedErrors::verdict() in one sentence, which stands beside every verdict.
inline std::string paired_rule() {
  return printed(
      "Rule for pairs of flights, in this order: fewer than %d pairs: cannot tell; the 95 %% interval of the "
      "difference (after minus before) inside +-%.0f %% of before: no difference; below zero: better; above "
      "zero: worse; otherwise: cannot tell.",
      kMinPairs, 100.0 * kNoDifference);
}

/// Precondition: as many errors before as after, pair by pair.
inline PairedErrors compare_pairs(const std::vector<double>& before_m, const std::vector<double>& after_m) {
  std::vector<double> differences_m(before_m.size());
  std::transform(after_m.begin(), after_m.end(), before_m.begin(), differences_m.begin(), std::minus<>());
  return {static_cast<int>(before_m.size()), mean_value(before_m), mean_value(after_m),
          mean_with_interval(differences_m)};
}

/// "0.0066 -> 0.0070 m, +0.0004 [+0.0002, +0.0006]: worse (5 pairs)"
inline std::string describe(const PairedErrors& errors) {
  // Adding 0.0 turns -0.0 into 0.0, which is printed without that sign.
  const auto rounded = [](double m) { return std::round(1e4 * m) / 1e4 + 0.0; };
  const auto& [value, low, high] = errors.difference_m;
  const std::string interval = std::isfinite(low)
                                   ? printed(", %+.4f [%+.4f, %+.4f]", rounded(value), rounded(low), rounded(high))
                                   : ", of which the spread is not known";
  return printed("%.4f -> %.4f m%s: %s (%d %s)", errors.before_m, errors.after_m, interval.c_str(), errors.verdict(),
                 errors.flights,
                 errors.flights == 1 ? "pair: the interval is the spread inside its two flights" : "pairs");
}

}  // namespace m100::lab
