// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/selection/criteria.h"

namespace m100::lab::identify {

/// The search of select(): adds effects to the present model and drops them (forward_selection.cpp), then compares the
/// effects found with their alternatives and may exchange them (rivals.cpp).
class ForwardSelection {
 public:
  ForwardSelection(const Family& family, const SelectionOptions& options);
  Selection run(const Structure& declared);

 private:
  static constexpr double kAny = std::numeric_limits<double>::infinity();
  struct TriedEdit {
    Family::Edit edit;
    CrossValidatedFit validated;
    Comparison comparison;
    bool accepted = false;
  };
  struct Pair {
    const TriedEdit* first;
    TriedEdit second;
    Comparison first_beside_second;
  };
  /// Alternatives to one effect, with all other effects kept.
  struct Replacements {
    std::size_t step;
    CrossValidatedFit without;
    std::vector<TriedEdit> singles;  ///< best first; the effect itself among them
    std::vector<Pair> pairs;         ///< of `singles`, best first
  };
  /// Indices of two of the steps.
  struct StepPair {
    std::size_t earlier, later;
  };
  struct Alias {
    std::string winner, name;
    Fit fit;
    double cv_ratio;
  };

  bool banned(const std::string& name) const;
  /// Fits an edit; cross-validates it unless it hardly fits better than `from` or its sum of squares exceeds `worth`.
  TriedEdit try_edit(const CrossValidatedFit& from, const Family::Edit& edit, double worth = kAny) const;
  TriedEdit cross_validated_edit(const CrossValidatedFit& from, const Family::Edit& edit, Fit fit,
                                 double worth = kAny) const;
  std::vector<TriedEdit> try_edits(const CrossValidatedFit& from) const;
  /// Fits the three best edits again from default values, because the present fit ended at the edge of a range.
  void restart_from_defaults(const CrossValidatedFit& from, std::vector<TriedEdit>& tried) const;
  const TriedEdit* winner_of(const std::vector<TriedEdit>& tried) const;
  CrossValidatedFit polished(CrossValidatedFit validated) const;
  void accept_edit(const TriedEdit& winner);
  bool add_one();
  std::optional<Pair> pair_of(const CrossValidatedFit& from, const TriedEdit& first,
                              const CrossValidatedFit& other_alone, const TriedEdit& second) const;
  std::optional<Pair> try_pair(const CrossValidatedFit& from, const TriedEdit& first, const Family::Edit& second,
                               CrossValidatedFit& alone, CrossValidatedFit& other_alone, double worth) const;
  /// @param candidates  so many of the best of `tried` are paired
  std::vector<Pair> pairs(const CrossValidatedFit& from, const std::vector<TriedEdit>& tried, double worth,
                          std::size_t candidates) const;
  std::optional<Pair> best_pair(const CrossValidatedFit& from, const std::vector<TriedEdit>& tried) const;
  void accept_pair(const Pair& pair);
  bool add_two();
  void retest();

  bool exchange_or_record_rivals();
  void name_departures(const Structure& declared);
  bool split(const std::vector<Replacements>& all);
  bool swap(const std::vector<Replacements>& all);
  void record_rivals(const std::vector<Replacements>& all);
  void record_single_rival(const TriedEdit& other, SelectionStep& step);
  void record_pair_rival(const Pair& pair, SelectionStep& step);
  void record_aliases(SelectionStep& step);
  bool join_or_record_pairs();
  bool join_or_record(const StepPair& two);
  bool exchange_or_record(const StepPair& two, const Pair& pair);
  void drop(const StepPair& two);
  bool near(double cv) const;
  double error_ratio(const TriedEdit& one) const;
  double max_rival_ratio() const;
  bool is_alias(const std::string& name) const;
  bool alias_of(const std::string& winner, const std::string& name) const;
  void exchange_alias(const std::string& old_name, const std::string& new_name, double cv_ratio);

  const Family& family_;
  const SelectionOptions& options_;
  double samples_ = 0.0;
  Selection out_;
  std::vector<TriedEdit> last_tried_;
  std::vector<std::string> banned_;
  std::vector<Alias> aliases_;
  int round_ = 0;
};

}  // namespace m100::lab::identify
