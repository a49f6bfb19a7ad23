// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/search/criteria.h"

namespace m100::lab::identify {

/// The search of select(): the present model and the moves that change it. Additions are in forward_selection.cpp,
/// alternatives to the effects found in rivals.cpp.
class ForwardSelection {
 public:
  ForwardSelection(const Family& family, const SelectionOptions& options);
  Selection run(const Structure& declared);

 private:
  static constexpr double kAny = std::numeric_limits<double>::infinity();
  struct Tried {
    Family::Edit edit;
    Judged judged;
    Comparison comparison;
    bool accepted = false;
  };
  struct Pair {
    const Tried* first;
    Tried second;
    Comparison first_beside_second;
  };
  /// Alternatives to one effect, with all other effects kept.
  struct Replacements {
    std::size_t step;
    Judged without;
    std::vector<Tried> singles;  ///< best first; the effect itself among them
    std::vector<Pair> pairs;     ///< of `singles`, best first
  };
  /// Two of the steps.
  struct Two {
    std::size_t earlier, later;
  };
  struct Alias {
    std::string winner, name;
    Fit fit;
    double cv_ratio;
  };

  bool banned(const std::string& name) const;
  /// Fits and cross-validates an edit; one with a training error above `worth` (sum of mean squares) is only fitted and
  /// not accepted.
  Tried try_edit(const Judged& from, const Family::Edit& edit, double worth = kAny) const;
  Tried judged_edit(const Judged& from, const Family::Edit& edit, Fit fit, double worth = kAny) const;
  std::vector<Tried> try_edits(const Judged& from) const;
  /// Fits the best few edits again from default values, because the present fit ended at an edge.
  void start_anew(const Judged& from, std::vector<Tried>& tried) const;
  const Tried* winner_of(const std::vector<Tried>& tried) const;
  void take(const Tried& winner);
  bool add_one();
  std::optional<Pair> pair_of(const Judged& from, const Tried& first, const Judged& other_alone,
                              const Tried& second) const;
  std::optional<Pair> try_pair(const Judged& from, const Tried& first, const Family::Edit& second, Judged& alone,
                               Judged& other_alone, double worth) const;
  std::vector<Pair> pairs(const Judged& from, const std::vector<Tried>& tried,
                          const std::vector<Family::HiddenPair>& offered, double worth = kAny) const;
  std::optional<Pair> best_pair(const Judged& from, const std::vector<Tried>& tried) const;
  void take_pair(const Pair& pair);
  bool add_two();
  void retest();

  bool exchange_or_note_rivals();
  bool split(const std::vector<Replacements>& all);
  bool swap(const std::vector<Replacements>& all);
  void note(const std::vector<Replacements>& all);
  void note_single(const Tried& other, Step& step);
  void note_pair(const Pair& pair, Step& step);
  void note_aliases(Step& step);
  bool join_or_note_pairs();
  bool join_or_note(const Two& two);
  bool exchange_or_note(const Two& two, const Pair& pair);
  void drop(const Two& two);
  bool near(double cv) const;
  double error_ratio(const Tried& one) const;
  double worth_judging() const;
  bool is_alias(const std::string& name) const;
  bool alias_of(const std::string& winner, const std::string& name) const;
  void exchange_alias(const std::string& old_name, const std::string& new_name, double cv_ratio);

  const Family& family_;
  const SelectionOptions& options_;
  double samples_;
  Selection out_;
  std::vector<Tried> last_tried_;
  std::vector<std::string> banned_;
  std::vector<Alias> aliases_;
  int round_ = 0;
};

}  // namespace m100::lab::identify
