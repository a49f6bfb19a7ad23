// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace m100::lab::identify {

// The interface between forward selection and models, shared by the stick axes and by translation. A family fits a
// structure to some blocks of a log and gives the error of every block; the selection knows nothing else.

/// Names of the base model and then of the effects, in the order in which they were added.
using Structure = std::vector<std::string>;
inline bool has(const Structure& structure, std::string_view name) {
  return std::find(structure.begin(), structure.end(), name) != structure.end();
}

/// A structure with fitted parameters; their meaning and order are defined by the family.
struct Fit {
  Structure structure;
  std::vector<double> parameters;
  std::string shape;            ///< variants of its effects, one after another; empty: none
  double sum_of_squares = 0.0;  ///< over the blocks it was fitted to
  std::size_t free_parameters = 0;
};

/// Models of one kind. The training part is split into blocks, numbered 0 .. block_count() - 1 range by range.
/// Preconditions of all functions: `weights` has block_count() entries, none of them negative and at least one
/// positive; a structure has its base model first and then effects that the family knows, each once.
class Family {
 public:
  Family() = default;
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;
  virtual ~Family() = default;

  virtual std::size_t block_count() const = 0;
  /// Number of axes whose errors follow each other in a block, all equally long.
  virtual std::size_t axes() const { return 1; }
  virtual std::size_t samples_in(std::size_t block) const = 0;
  /// Fits to the blocks whose weight is positive (an integer weight counts a block several times).
  /// Without `warm` it tries several starts. With `warm` of the same structure it starts there and takes few
  /// iterations. With `warm` of another structure, common parameters start there and new ones from several starts.
  virtual Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const = 0;
  /// Searches a better optimum of the same structure, with the effects set to their starts in turn. Default: no search.
  virtual Fit polish(const Fit& fit, std::span<const int> weights) const {
    static_cast<void>(weights);
    return fit;
  }
  /// Simulation errors of the blocks with a positive weight, sample by sample (several axes: one after the other);
  /// empty vectors for the others.
  virtual std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const = 0;
  /// A structure that one edit produces, with the name of the edit.
  struct Edit {
    std::string name;
    Structure structure;
  };
  virtual std::vector<Edit> edits(const Structure& present) const = 0;
  /// The declared structure with the nuisance parameters that every model of this family has. Default: none.
  virtual Structure completed(const Structure& declared) const { return declared; }
  /// The structure without effect `name`; the same structure if the effect cannot be removed.
  virtual Structure without(const Structure& structure, const std::string& name) const = 0;
  /// The model of `fit` without effect `name`. Default: all other parameters are fitted again.
  virtual Fit switched_off(const Fit& fit, const std::string& name) const {
    return this->fit(without(fit.structure, name), std::vector<int>(block_count(), 1), &fit);
  }
  /// Whether the size of effect `name` in this fit is physically significant.
  virtual bool is_significant(const Fit& fit, const std::string& name) const = 0;
  /// Whether a parameter of the fit is at the edge of its physical range: then it probably compensates another effect,
  /// and the fit is no good start for that effect.
  virtual bool is_at_bound(const Fit& fit) const {
    static_cast<void>(fit);
    return false;
  }
  /// The structure of the fit with other variants of its effects, fitted to all blocks.
  virtual std::vector<Fit> variants(const Fit& fit) const {
    static_cast<void>(fit);
    return {};
  }
  /// Whether the log cannot distinguish effect `name` from `rival`. Then only `name` is fitted; `rival` is reported.
  virtual bool alias(const Fit& winner, const std::string& name, const std::string& rival) const {
    static_cast<void>(winner), static_cast<void>(name), static_cast<void>(rival);
    return false;
  }
};

}  // namespace m100::lab::identify
