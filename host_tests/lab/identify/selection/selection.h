// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

// Forward selection of model edits. It knows neither stick axes nor translation, only the interface Family.

struct SelectionOptions {
  double minimum_cv_gain = 0.04;
  double minimum_delta_bic = 6.0;
  double minimum_delta_white = 15.0;  ///< alternative: delta_white above this, with a paired t above minimum_t_white
  double min_delta_white = 8.0;       ///< least delta_white in any case: logs with nothing hidden reach 7.1
  double minimum_t_white = 1.0;       ///< where delta_bic is not above 0, minimum_t instead
  double minimum_t = 1.7;
  double strong_delta_bic = 10.0;  ///< above it, a paired t above minimum_t_strong is enough
  double minimum_t_strong = 0.3;
  double rival_margin = 0.05;     ///< cross-validated root mean square within this share of the model's: not separable
  double max_rival_ratio = 1.25;  ///< of training mean squares; a rival above it is not cross-validated
  double keep_cv_gain = 0.02;     ///< an earlier effect with a smaller gain is dropped
  double simpler_margin = 0.02;   ///< of the cross-validated mean square; within it, fewer parameters win
  std::size_t pair_candidates = 6;  ///< so many best edits are paired if none is accepted alone, and as rivals
  double split_gain = 0.15;         ///< share by which a pair that replaces one effect must reduce the mean square
  std::size_t pairs_up_to = 3;      ///< with more effects than this, no pair is tried in the place of one
  std::size_t folds = 5;
  std::size_t start_samples = 0;  ///< samples at the start of each block that depend on its initial state
  std::size_t maximum_effects = 5;
  std::function<void(const std::string&)> progress;  ///< called with one short line per effect found; may be empty
};

struct CrossValidatedFit {
  Fit fit;                       ///< to all blocks
  std::vector<double> cv_block;  ///< sum of squares of each block, predicted by the fit to the other folds
  double cv = 0.0;               ///< their sum
  double effective_samples = 0.0;
  std::vector<std::vector<double>> errors;  ///< of the fit to all blocks, block by block; empty in a Selection
};

struct SelectionStep {
  std::string name;
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double paired_t = 0.0;
  struct RivalFit {
    std::string name;
    Fit fit;
    double cv_ratio = 1.0;
  };
  std::vector<RivalFit> rivals;
};

/// Largest factor by which a kept effect may increase the validation error. An effect with weak evidence must reduce
/// the error. One with strong evidence is kept where the error hardly changes, because the validation part may not
/// exercise the effect at all.
constexpr double max_validation_ratio(const SelectionStep& step) {
  constexpr double kStrongGain = 0.15;
  constexpr double kStrongCriterion = 15.0;
  constexpr double kIndifferent = 1.05;
  return step.cv_gain > kStrongGain && step.delta_bic > kStrongCriterion ? kIndifferent : 1.0;
}

struct Selection {
  CrossValidatedFit declared;
  CrossValidatedFit final_model;
  std::vector<SelectionStep> steps;  ///< the effects that were kept, in order of acceptance
  std::vector<CandidateRow> table;
  std::vector<std::vector<std::string>> not_separable;  ///< groups of rivals; three or four names with pairs
  std::vector<std::string> notes;                       ///< sentences for the report
  std::vector<Fit> alternatives;                        ///< the edits of the last round that were not accepted
};

/// Starts from `declared` and edits it as long as an edit is accepted. With fewer blocks than `folds`, each block is a
/// fold. Precondition: `declared` is a structure of the family. Cost: about folds * candidates fits per effect found.
Selection select(const Family& family, const Structure& declared, const SelectionOptions& options);

}  // namespace m100::lab::identify
