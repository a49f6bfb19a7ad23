// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/search/family.h"

namespace m100::lab::identify {

// Forward selection of model edits. It knows neither stick axes nor translation, only their families.

struct SelectionOptions {
  double minimum_cv_gain = 0.04;
  double minimum_delta_bic = 6.0;
  double minimum_delta_white = 15.0;  ///< or this much on whitened residuals, with minimum_t_white
  double least_delta_white = 8.0;     ///< with less nothing else convinces: logs with nothing hidden reach 7.1
  double minimum_t_white = 1.0;       ///< and minimum_t where the first criterion says no
  double minimum_t = 1.7;
  double strong_delta_bic = 10.0;  ///< with this much, minimum_t_strong is enough
  double minimum_t_strong = 0.3;
  double rival_margin = 0.05;       ///< cross-validated root mean square within this of the winner's: not separable
  double worth_judging = 1.25;      ///< rivals that fit worse than this, in mean squares, are not cross-validated
  double keep_cv_gain = 0.02;       ///< an earlier effect that earns less is dropped
  double simpler_margin = 0.02;     ///< within this, the candidate with fewer parameters wins
  std::size_t pair_candidates = 6;  ///< when no single edit convinces, pairs of this many best ones are tried
  double split_gain = 0.15;         ///< a pair must be this much better than the one effect that stood in for it
  std::size_t pairs_up_to = 3;      ///< effects; with more, two in the place of one are not tried
  std::size_t folds = 5;
  std::size_t start_samples = 0;  ///< of each block, in which the state shows that it was started from
  std::size_t maximum_effects = 5;
  std::function<void(const std::string&)> progress;  ///< called with one short line per round; may be empty
};

/// Cross-validated fit of one structure.
struct Judged {
  Fit fit;                       ///< to all blocks
  std::vector<double> cv_block;  ///< sum of squares of each block, predicted by the fit to the other folds
  double cv = 0.0;               ///< their sum
  double effective_samples = 0.0;
  std::vector<std::vector<double>> errors;  ///< of the fit to all blocks, block by block
};

struct Step {
  std::string name;
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double paired_t = 0.0;
  struct Runner {
    std::string name;
    Fit fit;
    double cv_ratio = 1.0;
  };
  std::vector<Runner> rivals;
  bool alias_of_rival = false;
};

/// The most that the error of the validation part may grow by an effect that stays. Weak evidence must make it smaller.
/// Strong evidence stands where the validation part is indifferent: it may not exercise the effect at all.
constexpr double most_in_validation(const Step& step) {
  constexpr double kStrongGain = 0.15;
  constexpr double kStrongCriterion = 15.0;
  constexpr double kIndifferent = 1.05;
  return step.cv_gain > kStrongGain && step.delta_bic > kStrongCriterion ? kIndifferent : 1.0;
}

struct Selection {
  Judged declared;
  Judged final_model;
  std::vector<Step> steps;  ///< the effects that stayed, in order of acceptance
  std::vector<CandidateRow> table;
  std::vector<std::vector<std::string>> not_separable;  ///< rivals; two and two where combinations are
  std::vector<std::string> notes;                       ///< sentences for the report
};

/// Starts from `declared` and edits it as long as an edit is accepted.
/// Preconditions: `declared` is a structure of the family; the family has at least as many blocks as folds are wanted
/// (2 or more), else fewer folds are used. Cost: about folds * candidates fits for each effect that is found.
Selection select(const Family& family, const Structure& declared, const SelectionOptions& options);

}  // namespace m100::lab::identify
