// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/plot/charts.h"

namespace m100::lab::hidden {

/// One log to be analysed without knowing its effects, and the expected result.
struct Case {
  FlightPlan plan;
  std::vector<std::string> declare;
  std::vector<std::vector<std::string>> expected;  ///< each hidden effect, with the names that count for it
  std::string verdict;                             ///< "nothing_missing", "explained" or "unexplained"
  std::string group;                               ///< "none", "single", "pair" or "outside"
  std::string label;                               ///< row of the table, e.g. "roll dead_zone"
  int size = 1;
};

struct Outcome {
  Case hidden_case;
  std::vector<std::string> found;
  std::vector<std::vector<std::string>> not_separable;
  std::vector<std::string> unexplained;
  std::string verdict;
  std::string failure;     ///< an exception's text; empty: none
  bool right = false;      ///< verdict as expected; unless outside the library, exactly the hidden effects named
  bool among_two = false;  ///< as `right`, but a rival reported as not separable counts as named
  double before = 0.0;     ///< root mean square error on the validation part, of the declared model
  double after = 0.0;      ///< of the final model
  double elapsed_s = 0.0;
};

/// Cycles over nothing hidden, every single effect in three sizes, pairs, and effects outside of the library, for roll
/// and translation, until there are `count` cases. The same seed gives the same list.
std::vector<Case> cases(std::size_t count, std::uint64_t seed);

/// Flies the case, identifies its log (train 3 to 30 s, validation 30 to 44 s), and compares with the expected result.
Outcome analyse(const Case& hidden_case);

/// Analyses all cases on a few threads; `done` is called from the thread that finished one, never from two at once.
std::vector<Outcome> analyse_all(const std::vector<Case>& list, unsigned threads,
                                 const std::function<void(const Outcome&, std::size_t)>& done);

/// The number of right results in one group of cases.
struct Score {
  std::string what;
  std::size_t right = 0;
  std::size_t count = 0;
  double goal = 0.0;  ///< required share of right results; 0: none
  double share() const { return count > 0 ? static_cast<double>(right) / static_cast<double>(count) : 1.0; }
};
std::vector<Score> scores(const std::vector<Outcome>& outcomes);

/// The confusion matrix of the cases with at most one effect: one row for what was hidden, one column for the first
/// effect named. Row and column 0 are "nothing"; the last column is the verdict "unexplained", the last rows are
/// effects outside of the library.
plot::HeatMap matrix_of(const std::vector<Outcome>& outcomes);

}  // namespace m100::lab::hidden
