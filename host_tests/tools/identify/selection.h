// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host_tests/tools/identify/result.h"

namespace m100::tools::identify {

// Forward selection of model edits, shared by the stick axes and by translation. It knows neither: an axis family says
// how to fit a structure to some blocks and what the error of every block then is.

/// Base model first, then effects, in the order in which they were added.
using Structure = std::vector<std::string>;

/// A structure with numbers. `parameters` are the family's own, in its own order.
struct Fit {
  Structure structure;
  std::vector<double> parameters;
  std::string shape;            ///< variant of an effect where it has one
  double sum_of_squares = 0.0;  ///< over the blocks it was fitted to
  std::size_t free_parameters = 0;
};

/// Blocks of the training part are numbered 0 .. block_count() - 1, in time order.
class Family {
 public:
  Family() = default;
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;
  virtual ~Family() = default;

  virtual std::size_t block_count() const = 0;
  virtual std::size_t samples_in(std::size_t block) const = 0;
  /// Fits to the blocks whose weight is positive (an integer weight counts a block several times: bootstrap).
  /// Without `warm`: from several starts. With `warm` of the same structure: from there, few iterations. With `warm` of
  /// another structure: what both have in common from there, what is new from several starts.
  virtual Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const = 0;
  /// A better optimum of the same structure, if one is found from other starts or variants of single effects.
  virtual Fit polish(const Fit& fit, std::span<const int> weights) const {
    static_cast<void>(weights);
    return fit;
  }
  /// Simulation error of one training block, sample by sample (several axes: one after the other).
  virtual std::vector<double> error(const Fit& fit, std::size_t block) const = 0;
  /// The same of all blocks with a positive weight; empty vectors for the others. Override where one pass is cheaper.
  virtual std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const {
    std::vector<std::vector<double>> out(block_count());
    for (std::size_t block = 0; block < out.size(); ++block) {
      if (weights[block] > 0) {
        out[block] = error(fit, block);
      }
    }
    return out;
  }
  /// The structures that one edit of `present` can make, each with the name of the edit.
  struct Edit {
    std::string name;
    Structure structure;
  };
  virtual std::vector<Edit> edits(const Structure& present) const = 0;
  /// The structure without effect `name`; the same structure if it cannot be taken out.
  virtual Structure without(const Structure& structure, const std::string& name) const = 0;
  /// Whether effect `name` in this fit is large enough to mean something physically.
  virtual bool big_enough(const Fit& fit, const std::string& name) const = 0;
  /// Whether the data can tell the two apart at all; true: never (then both are named, and never both fitted).
  virtual bool alias(const Fit& winner, const std::string& name, const std::string& rival) const {
    static_cast<void>(winner), static_cast<void>(name), static_cast<void>(rival);
    return false;
  }
};

struct SelectionOptions {
  double minimum_cv_gain = 0.04;
  double minimum_delta_bic = 6.0;
  double minimum_delta_white = 15.0;  ///< or this much on whitened residuals, with minimum_t_white
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
Selection select(const Family& family, const Structure& declared, const SelectionOptions& options);

}  // namespace m100::tools::identify
