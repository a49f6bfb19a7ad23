// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/forward_selection.h"

#include <algorithm>
#include <array>
#include <utility>

namespace m100::lab::identify {

// Whether a cross-validated sum of squares is, in root mean square, within the rival margin of the final model's.
bool ForwardSelection::near(double cv) const {
  return cv < (1.0 + options_.rival_margin) * (1.0 + options_.rival_margin) * out_.final_model.cv;
}

double ForwardSelection::error_ratio(const TriedEdit& one) const { return one.validated.cv / out_.final_model.cv; }

// Largest training sum of squares of a rival: one that fits clearly worse than the final model predicts worse, too.
double ForwardSelection::max_rival_ratio() const {
  return options_.max_rival_ratio * out_.final_model.fit.sum_of_squares;
}

// Compares every effect with every other edit, and with pairs of the best edits, in its place, with all other effects
// kept. A clearly better one, or a simpler one that is as good, replaces it; one nearly as good is a rival.
bool ForwardSelection::exchange_or_record_rivals() {
  std::vector<Replacements> all;
  for (std::size_t at = 0; at < out_.steps.size(); ++at) {
    const Structure reduced = family_.without(out_.final_model.fit.structure, out_.steps[at].name);
    if (reduced == out_.final_model.fit.structure) {
      continue;
    }
    Replacements one{at, cross_validated_fit(family_, reduced, &out_.final_model.fit, options_.folds), {}, {}};
    const std::string& own = out_.steps[at].name;
    for (const Family::Edit& edit : family_.edits(reduced)) {
      if (!is_alias(edit.name) || alias_of(own, edit.name)) {
        one.singles.push_back(try_edit(one.without, edit, max_rival_ratio()));
      }
    }
    std::sort(one.singles.begin(), one.singles.end(),
              [](const TriedEdit& a, const TriedEdit& b) { return a.validated.cv < b.validated.cv; });
    all.push_back(std::move(one));
    if (out_.steps.size() <= options_.pairs_up_to) {
      all.back().pairs = pairs(all.back().without, all.back().singles, max_rival_ratio(), options_.pair_candidates);
    }
  }
  if (split(all) || swap(all)) {
    return true;
  }
  record_rivals(all);
  return false;
}

// Replaces one effect that imitated two, such as a gain asymmetry instead of a trim on a curved stick.
bool ForwardSelection::split(const std::vector<Replacements>& all) {
  if (out_.steps.size() + 1 > options_.maximum_effects || out_.steps.size() > 2) {
    return false;
  }
  for (const Replacements& one : all) {
    if (!one.pairs.empty() &&
        one.pairs.front().second.validated.cv < (1.0 - options_.split_gain) * out_.final_model.cv) {
      out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(one.step));
      accept_pair(one.pairs.front());
      return true;
    }
  }
  return false;
}

bool ForwardSelection::swap(const std::vector<Replacements>& all) {
  for (const Replacements& one : all) {
    SelectionStep& step = out_.steps[one.step];
    for (const TriedEdit& other : one.singles) {
      if (!other.accepted || other.edit.name == step.name) {
        continue;
      }
      const double ratio = error_ratio(other);
      const bool simpler = other.validated.fit.free_parameters < out_.final_model.fit.free_parameters;
      if (ratio < 1.0 - options_.simpler_margin || (simpler && ratio < 1.0 + options_.simpler_margin)) {
        exchange_alias(step.name, other.edit.name, 1.0 / ratio);
        step.name = other.edit.name;
        step.cv_gain = other.comparison.cv_gain;
        step.delta_bic = other.comparison.delta_bic;
        step.paired_t = other.comparison.t;
        out_.final_model = other.validated;
        return true;
      }
    }
  }
  return false;
}

void ForwardSelection::record_rivals(const std::vector<Replacements>& all) {
  out_.not_separable.clear();
  out_.notes.clear();
  for (SelectionStep& step : out_.steps) {
    step.rivals.clear();
  }
  for (const Replacements& one : all) {
    SelectionStep& step = out_.steps[one.step];
    for (const TriedEdit& other : one.singles) {
      record_single_rival(other, step);
    }
    for (const Pair& pair : one.pairs) {
      record_pair_rival(pair, step);
    }
    record_aliases(step);
  }
}

void ForwardSelection::record_single_rival(const TriedEdit& other, SelectionStep& step) {
  if (other.accepted && other.edit.name != step.name && near(other.validated.cv) && !is_alias(other.edit.name)) {
    step.rivals.push_back({other.edit.name, other.validated.fit, error_ratio(other)});
    out_.not_separable.push_back({step.name, other.edit.name});
  }
}

void ForwardSelection::record_pair_rival(const Pair& pair, SelectionStep& step) {
  const std::string& first = pair.first->edit.name;
  const std::string& second = pair.second.edit.name;
  if (first != step.name && second != step.name && near(pair.second.validated.cv)) {
    step.rivals.push_back({first + " + " + second, pair.second.validated.fit, error_ratio(pair.second)});
    out_.not_separable.push_back({step.name, first, second});
    out_.notes.push_back(first + " + " + second + " predict as well as " + step.name +
                         ": the log cannot tell them apart, and the simpler one is named");
  }
}

void ForwardSelection::record_aliases(SelectionStep& step) {
  for (const Alias& alias : aliases_) {
    if (alias.winner == step.name) {
      step.rivals.push_back({alias.name, alias.fit, alias.cv_ratio});
      out_.not_separable.push_back({step.name, alias.name});
    }
  }
}

bool ForwardSelection::join_or_record_pairs() {
  for (std::size_t a = 0; a < out_.steps.size(); ++a) {
    for (std::size_t b = a + 1; b < out_.steps.size(); ++b) {
      if (join_or_record({a, b})) {
        return true;
      }
    }
  }
  return false;
}

// Compares two effects with any single effect, and with pairs of others, in their place. A single effect that predicts
// as well replaces them, a pair only if it predicts clearly better. @returns whether they were replaced.
bool ForwardSelection::join_or_record(const StepPair& two) {
  const Structure& whole = out_.final_model.fit.structure;
  const Structure one_less = family_.without(whole, out_.steps[two.later].name);
  const Structure reduced = family_.without(one_less, out_.steps[two.earlier].name);
  if (one_less == whole || reduced == one_less) {
    return false;
  }
  const CrossValidatedFit without = cross_validated_fit(family_, reduced, &out_.final_model.fit, options_.folds);
  std::vector<TriedEdit> tried;
  for (const Family::Edit& edit : family_.edits(reduced)) {
    if (!is_alias(edit.name)) {
      tried.push_back(try_edit(without, edit, max_rival_ratio()));
    }
  }
  std::sort(tried.begin(), tried.end(),
            [](const TriedEdit& a, const TriedEdit& b) { return a.validated.cv < b.validated.cv; });
  const TriedEdit* one = winner_of(tried);
  if (one != nullptr && one->validated.cv < out_.final_model.cv * (1.0 + options_.simpler_margin) &&
      one->validated.fit.free_parameters <= out_.final_model.fit.free_parameters) {
    drop(two);
    accept_edit(*one);
    return true;
  }
  // Two effects that hide each other are among the worst single ones: if only two are named, all pairs are compared.
  const std::size_t candidates = out_.steps.size() == 2 ? tried.size() : options_.pair_candidates;
  const std::vector<Pair> others = pairs(without, tried, max_rival_ratio(), candidates);
  return std::any_of(others.begin(), others.end(), [&](const Pair& pair) { return exchange_or_record(two, pair); });
}

// Replaces two effects by another two that predict clearly better; reports another two that predict equally well.
bool ForwardSelection::exchange_or_record(const StepPair& two, const Pair& pair) {
  const std::array<std::string, 2> own{out_.steps[two.earlier].name, out_.steps[two.later].name};
  const std::array<std::string, 2> other{pair.first->edit.name, pair.second.edit.name};
  const bool shares = std::find_first_of(own.begin(), own.end(), other.begin(), other.end()) != own.end();
  if (shares || !near(pair.second.validated.cv)) {
    return false;  // if only one of the two differs, it is a single rival
  }
  const double ratio = error_ratio(pair.second);
  if (ratio < 1.0 - options_.simpler_margin) {
    drop(two);
    accept_pair(pair);
    return true;
  }
  for (const std::size_t at : {two.earlier, two.later}) {
    out_.steps[at].rivals.push_back({other[0] + " + " + other[1], pair.second.validated.fit, ratio});
  }
  out_.not_separable.push_back({own[0], own[1], other[0], other[1]});
  out_.notes.push_back(own[0] + " + " + own[1] + " and " + other[0] + " + " + other[1] +
                       " predict equally well: the log cannot tell which of the two is there");
  return false;
}

void ForwardSelection::drop(const StepPair& two) {
  out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(two.later));
  out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(two.earlier));
}

bool ForwardSelection::is_alias(const std::string& name) const {
  return std::any_of(aliases_.begin(), aliases_.end(), [&](const Alias& alias) { return alias.name == name; });
}

bool ForwardSelection::alias_of(const std::string& winner, const std::string& name) const {
  return std::any_of(aliases_.begin(), aliases_.end(),
                     [&](const Alias& alias) { return alias.winner == winner && alias.name == name; });
}

// Exchanges an effect with its alias: the first choice may have been wrong while another effect was missing.
void ForwardSelection::exchange_alias(const std::string& old_name, const std::string& new_name, double cv_ratio) {
  for (Alias& alias : aliases_) {
    if (alias.winner == old_name && alias.name == new_name) {
      alias = {new_name, old_name, out_.final_model.fit, cv_ratio};
      std::erase(banned_, new_name);
      banned_.push_back(old_name);
    }
  }
}

}  // namespace m100::lab::identify
