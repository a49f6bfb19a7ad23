// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/forward_selection.h"

#include <algorithm>
#include <span>
#include <utility>

namespace m100::lab::identify {

namespace {

SelectionStep step_of(const std::string& name, const Comparison& comparison) {
  return {name, comparison.cv_gain, comparison.delta_bic, comparison.t, {}};
}

}  // namespace

ForwardSelection::ForwardSelection(const Family& family, const SelectionOptions& options)
    : family_(family), options_(options) {
  for (std::size_t block = 0; block < family.block_count(); ++block) {
    samples_ += static_cast<double>(family.samples_in(block));
  }
}

Selection ForwardSelection::run(const Structure& declared) {
  // Without polished() the first edit would be credited with what the fit of the declared model had missed.
  out_.declared = polished(cross_validated_fit(family_, family_.completed(declared), nullptr, options_.folds));
  out_.final_model = out_.declared;
  // After a swap another addition may be accepted; the bound only prevents an endless cycle.
  for (int pass = 0; pass < 4; ++pass) {
    while (out_.steps.size() < options_.maximum_effects && (add_one() || add_two())) {
      retest();
    }
    if (!exchange_or_record_rivals() && !join_or_record_pairs()) {
      break;
    }
  }
  name_departures(declared);
  for (const TriedEdit& one : last_tried_) {
    if (!one.accepted) {
      out_.alternatives.push_back(one.validated.fit);
    }
  }
  return std::move(out_);
}

bool ForwardSelection::banned(const std::string& name) const {
  return std::find(banned_.begin(), banned_.end(), name) != banned_.end();
}

ForwardSelection::TriedEdit ForwardSelection::try_edit(const CrossValidatedFit& from, const Family::Edit& edit,
                                                       double worth) const {
  return cross_validated_edit(
      from, edit, family_.fit(edit.structure, std::vector<int>(family_.block_count(), 1), &from.fit), worth);
}

ForwardSelection::TriedEdit ForwardSelection::cross_validated_edit(const CrossValidatedFit& from,
                                                                   const Family::Edit& edit, Fit fit,
                                                                   double worth) const {
  TriedEdit tried{edit, {}, {}, false};
  tried.validated.fit = std::move(fit);
  // An edit that hardly fits better, or worse than `worth`, could not be accepted, so it is not cross-validated.
  const double kept = tried.validated.fit.sum_of_squares / from.fit.sum_of_squares;
  if (1.0 - kept < options_.minimum_cv_gain || tried.validated.fit.sum_of_squares > worth) {
    tried.validated.cv_block = from.cv_block;
    tried.validated.cv = from.cv * std::min(1.0, kept);
    tried.validated.effective_samples = from.effective_samples;
    tried.comparison = compare(from, tried.validated, samples_, options_.start_samples);
    return tried;
  }
  cross_validate(family_, tried.validated, options_.folds);
  tried.comparison = compare(from, tried.validated, samples_, options_.start_samples);
  tried.accepted = convincing(tried.comparison, options_) && family_.is_significant(tried.validated.fit, edit.name);
  return tried;
}

std::vector<ForwardSelection::TriedEdit> ForwardSelection::try_edits(const CrossValidatedFit& from) const {
  std::vector<TriedEdit> tried;
  for (const Family::Edit& edit : family_.edits(from.fit.structure)) {
    if (!banned(edit.name)) {
      tried.push_back(try_edit(from, edit));
    }
  }
  std::sort(tried.begin(), tried.end(),
            [](const TriedEdit& a, const TriedEdit& b) { return a.validated.cv < b.validated.cv; });
  return tried;
}

void ForwardSelection::restart_from_defaults(const CrossValidatedFit& from, std::vector<TriedEdit>& tried) const {
  constexpr std::size_t kFew = 3;
  for (std::size_t k = 0; k < std::min(kFew, tried.size()); ++k) {
    const Fit anew = family_.fit(tried[k].edit.structure, std::vector<int>(family_.block_count(), 1), nullptr);
    if (anew.sum_of_squares < tried[k].validated.fit.sum_of_squares) {
      tried[k] = cross_validated_edit(from, Family::Edit(tried[k].edit), anew);
    }
  }
  std::sort(tried.begin(), tried.end(),
            [](const TriedEdit& a, const TriedEdit& b) { return a.validated.cv < b.validated.cv; });
}

// The best accepted edit; a simpler one that is as good is preferred.
const ForwardSelection::TriedEdit* ForwardSelection::winner_of(const std::vector<TriedEdit>& tried) const {
  const TriedEdit* winner = nullptr;
  for (const TriedEdit& one : tried) {
    const auto simpler_and_as_good = [&] {
      return one.validated.fit.free_parameters < winner->validated.fit.free_parameters &&
             one.validated.cv < winner->validated.cv * (1.0 + options_.simpler_margin);
    };
    if (one.accepted && (winner == nullptr || simpler_and_as_good())) {
      winner = &one;
    }
  }
  return winner;
}

// A better optimum of the same structure, where there is one that also predicts better.
CrossValidatedFit ForwardSelection::polished(CrossValidatedFit validated) const {
  const Fit fit = family_.polish(validated.fit, std::vector<int>(family_.block_count(), 1));
  if (fit.sum_of_squares < 0.995 * validated.fit.sum_of_squares) {
    CrossValidatedFit better = cross_validated_fit(family_, fit.structure, &fit, options_.folds);
    return better.cv < validated.cv ? better : validated;
  }
  return validated;
}

void ForwardSelection::accept_edit(const TriedEdit& winner) {
  out_.steps.push_back(step_of(winner.edit.name, winner.comparison));
  out_.final_model = polished(winner.validated);
  if (options_.progress) {
    options_.progress("found " + winner.edit.name);
  }
}

bool ForwardSelection::add_one() {
  last_tried_ = try_edits(out_.final_model);
  const TriedEdit* winner = winner_of(last_tried_);
  if (winner == nullptr && family_.is_at_bound(out_.final_model.fit)) {
    restart_from_defaults(out_.final_model, last_tried_);
    winner = winner_of(last_tried_);
  }
  for (const TriedEdit& one : last_tried_) {
    out_.table.push_back({round_, one.edit.name, one.comparison.cv_gain, one.comparison.delta_bic,
                          one.comparison.delta_white, one.comparison.t,
                          family_.is_significant(one.validated.fit, one.edit.name), one.accepted, &one == winner});
  }
  ++round_;
  if (winner == nullptr) {
    return false;
  }
  for (const TriedEdit& other : last_tried_) {
    if (&other != winner && family_.alias(winner->validated.fit, winner->edit.name, other.edit.name)) {
      banned_.push_back(other.edit.name);
      aliases_.push_back(
          {winner->edit.name, other.edit.name, other.validated.fit, other.validated.cv / winner->validated.cv});
    }
  }
  accept_edit(*winner);
  return true;
}

// `second` was accepted beside `first`. The two are a pair if `first` is also accepted beside `second`, and if both
// together are convincing as an edit of `from`, with a delta_bic above strong_delta_bic.
std::optional<ForwardSelection::Pair> ForwardSelection::pair_of(const CrossValidatedFit& from, const TriedEdit& first,
                                                                const CrossValidatedFit& other_alone,
                                                                const TriedEdit& second) const {
  const Comparison beside = compare(other_alone, second.validated, samples_, options_.start_samples);
  const Comparison both = compare(from, second.validated, samples_, options_.start_samples);
  if (!convincing(beside, options_) || !convincing(both, options_) || both.delta_bic <= options_.strong_delta_bic ||
      !family_.is_significant(second.validated.fit, first.edit.name)) {
    return std::nullopt;
  }
  return Pair{&first, second, beside};
}

// The pair of `first` and the edit `second`, if it fits and predicts well enough. `alone` and `other_alone` are the two
// single edits; they are cross-validated here when they are first needed.
std::optional<ForwardSelection::Pair> ForwardSelection::try_pair(const CrossValidatedFit& from, const TriedEdit& first,
                                                                 const Family::Edit& second, CrossValidatedFit& alone,
                                                                 CrossValidatedFit& other_alone, double worth) const {
  Fit fit = family_.fit(second.structure, std::vector<int>(family_.block_count(), 1), &alone.fit);
  const double minimum = std::min(alone.fit.sum_of_squares, other_alone.fit.sum_of_squares);
  if (fit.sum_of_squares > (1.0 - options_.minimum_cv_gain) * minimum || fit.sum_of_squares > worth) {
    return std::nullopt;  // it does not fit better
  }
  const auto validated = [this](CrossValidatedFit& one) -> const CrossValidatedFit& {
    if (one.errors.empty()) {
      cross_validate(family_, one, options_.folds);
    }
    return one;
  };
  const TriedEdit beside = cross_validated_edit(validated(alone), second, std::move(fit), worth);
  return beside.accepted ? pair_of(from, first, validated(other_alone), beside) : std::nullopt;
}

// The pairs of edits that are accepted together, best first. Two effects may hide each other (a dead zone and a trim),
// so each must be convincing in addition to the other; alone it may have no gain. `tried` are the single edits of
// `from`, best first.
std::vector<ForwardSelection::Pair> ForwardSelection::pairs(const CrossValidatedFit& from,
                                                            const std::vector<TriedEdit>& tried, double worth,
                                                            std::size_t candidates) const {
  const auto few = std::span(tried).first(std::min(candidates, tried.size()));
  std::vector<CrossValidatedFit> alone;
  for (const TriedEdit& one : few) {
    alone.push_back(one.validated);
  }
  std::vector<Pair> out;
  for (std::size_t a = 0; a < few.size(); ++a) {
    for (const Family::Edit& edit : family_.edits(alone[a].fit.structure)) {
      const auto other = std::find_if(few.begin() + static_cast<std::ptrdiff_t>(a) + 1, few.end(),
                                      [&](const TriedEdit& one) { return one.edit.name == edit.name; });
      if (other == few.end() || family_.alias(alone[a].fit, few[a].edit.name, edit.name)) {
        continue;
      }
      CrossValidatedFit& other_alone = alone[static_cast<std::size_t>(other - few.begin())];
      if (std::optional<Pair> pair = try_pair(from, few[a], edit, alone[a], other_alone, worth)) {
        out.push_back(std::move(*pair));
      }
    }
  }
  std::sort(out.begin(), out.end(),
            [](const Pair& a, const Pair& b) { return a.second.validated.cv < b.second.validated.cv; });
  return out;
}

std::optional<ForwardSelection::Pair> ForwardSelection::best_pair(const CrossValidatedFit& from,
                                                                  const std::vector<TriedEdit>& tried) const {
  std::vector<Pair> all = pairs(from, tried, kAny, options_.pair_candidates);
  return all.empty() ? std::nullopt : std::optional<Pair>(std::move(all.front()));
}

void ForwardSelection::accept_pair(const Pair& pair) {
  out_.steps.push_back(step_of(pair.first->edit.name, pair.first_beside_second));
  for (const auto& [name, comparison] : {std::pair{pair.first->edit.name, pair.first_beside_second},
                                         std::pair{pair.second.edit.name, pair.second.comparison}}) {
    out_.table.push_back({round_, name, comparison.cv_gain, comparison.delta_bic, comparison.delta_white, comparison.t,
                          true, true, true});
  }
  ++round_;
  accept_edit(pair.second);
}

bool ForwardSelection::add_two() {
  if (out_.steps.size() + 2 > options_.maximum_effects) {
    return false;
  }
  const std::optional<Pair> pair = best_pair(out_.final_model, last_tried_);
  if (pair) {
    accept_pair(*pair);
  }
  return pair.has_value();
}

// Drops earlier effects whose gain in addition to the later ones is too small.
void ForwardSelection::retest() {
  for (std::size_t at = 0; at + 1 < out_.steps.size();) {
    const std::string name = out_.steps[at].name;
    const Structure reduced = family_.without(out_.final_model.fit.structure, name);
    if (reduced == out_.final_model.fit.structure) {
      ++at;
      continue;
    }
    const CrossValidatedFit validated = cross_validated_fit(family_, reduced, &out_.final_model.fit, options_.folds);
    if (1.0 - out_.final_model.cv / validated.cv < options_.keep_cv_gain) {
      out_.final_model = validated;
      out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(at));
      banned_.push_back(name);
    } else {
      ++at;
    }
  }
}

// Names a nuisance parameter where the model at its declared value is refuted, and records what could take its place.
void ForwardSelection::name_departures(const Structure& declared) {
  for (const std::string& name : Structure(out_.declared.fit.structure)) {
    const Fit& fit = out_.final_model.fit;
    if (has(declared, name) || !family_.is_significant(fit, name)) {
      continue;
    }
    const CrossValidatedFit without =
        cross_validated_fit(family_, family_.without(fit.structure, name), &fit, options_.folds);
    const Comparison comparison = compare(without, out_.final_model, samples_, options_.start_samples);
    const bool named = convincing(comparison, options_);
    out_.table.push_back({round_, name, comparison.cv_gain, comparison.delta_bic, comparison.delta_white, comparison.t,
                          true, named, named});
    if (named) {
      out_.steps.insert(out_.steps.begin(), step_of(name, comparison));
      for (const Family::Edit& edit : family_.edits(without.fit.structure)) {
        if (edit.name != name) {
          record_single_rival(try_edit(without, edit, max_rival_ratio()), out_.steps.front());
        }
      }
    }
  }
}

Selection select(const Family& family, const Structure& declared, const SelectionOptions& options) {
  Selection out = ForwardSelection(family, options).run(declared);
  out.declared.errors = out.final_model.errors = {};
  return out;
}

}  // namespace m100::lab::identify
