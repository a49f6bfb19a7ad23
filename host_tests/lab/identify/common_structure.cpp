// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/common_structure.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/selection/criteria.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {
namespace {

/// Null if the parts are of two logs, or if the validation part does not allow a fit.
std::unique_ptr<AxisProblem> with_parts_exchanged(const AxisProblem& problem) {
  try {
    return in_one_log(problem.request()) ? problem.exchanged() : nullptr;
  } catch (const InputError&) {
    return nullptr;
  }
}

class CommonStructure {
 public:
  CommonStructure(const AxisProblem& problem, Selection& selection)
      : problem_(problem),
        family_(problem.axis_family()),
        selection_(selection),
        run_(problem.free_run()),
        exchanged_(with_parts_exchanged(problem)) {
    if (exchanged_ != nullptr) {
      present_ = judged(selection.final_model.fit);
    }
  }

  std::optional<WeakEffect> run() {
    if (exchanged_ == nullptr) {
      return search(selection_.final_model.fit);
    }
    std::optional<WeakEffect> lacking;
    for (std::size_t round = 0; round < SelectionOptions{}.maximum_effects; ++round) {
      settle_exchanges();
      lacking = search(present_.fit);
      if (!lacking || !add(lacking->name)) {
        break;
      }
    }
    if (lacking) {  // an answer "this one or that one" lacks only what both lack
      const auto stands_in = [&](const Rival& rival) { return rival.name == lacking->name; };
      const auto rival = std::find_if(rivals_.begin(), rivals_.end(), stands_in);
      lacking = rival == rivals_.end() ? lacking : search(rival->fit);
    }
    name_nuisances();
    return lacking;
  }

 private:
  std::optional<WeakEffect> search(const Fit& fit) const {
    return weak_effect(problem_.training().signals.data, problem_.free_ranges(), family_, fit);
  }

  /// A fit to the training part, judged by all data.
  struct Judged {
    Fit fit;
    double criterion = 0.0;  ///< Schwarz's, of whitened free runs over both parts
    double error = 0.0;      ///< sum of squares of both parts, each predicted by a fit to the other
  };
  struct Rival {
    std::string name;
    Fit fit;
  };

  Judged judged(const Fit& fit) const {
    const AxisFamily& other = exchanged_->axis_family();
    const Fit start = other.with_parameters_of(fit, family_.model(fit));
    const Fit fitted = other.fit(fit.structure, std::vector<int>(other.block_count(), 1), &start);
    return {
        fit,
        unchanged_fit(run_, family_, fit).score +
            static_cast<double>(fit.free_parameters) * std::log(static_cast<double>(run_.size())),
        lagged_product(problem_.validation_errors(fit), 0) + lagged_product(exchanged_->validation_errors(fitted), 0)};
  }

  /// The better prediction counts first; where two predict alike, the likelihood.
  bool is_better(const Judged& one) const {
    const double margin = options_.simpler_margin;
    return one.error < (1.0 - margin) * present_.error ||
           (one.error < (1.0 + margin) * present_.error &&
            one.criterion + options_.minimum_delta_bic < present_.criterion);
  }

  /// All data exclude neither: the likelihood prefers the one and the prediction the other, or they differ too little.
  bool is_rival(const Judged& one) const {
    return one.error < (1.0 + options_.rival_margin) * (1.0 + options_.rival_margin) * present_.error &&
           one.criterion < present_.criterion + options_.minimum_delta_bic;
  }

  Fit fitted(const Structure& structure) const {
    return family_.fit(structure, std::vector<int>(family_.block_count(), 1), &present_.fit);
  }

  /// Exchanges effects with better ones in their place, one after another.
  void settle_exchanges() {
    bool moved = true;
    for (std::size_t pass = 0; moved && pass < options_.maximum_effects; ++pass) {
      rivals_.clear();
      moved = false;
      for (std::size_t at = 0; !moved && at < selection_.steps.size(); ++at) {
        moved = exchange(at);
      }
    }
  }

  bool exchange(std::size_t at) {
    const std::string own = selection_.steps[at].name;
    const Structure reduced = family_.without(present_.fit.structure, own);
    if (reduced == present_.fit.structure || family_.completed(reduced) != reduced) {
      return false;
    }
    for (const Family::Edit& edit : family_.edits(reduced)) {
      const Fit fit = edit.name == own ? Fit{} : fitted(edit.structure);
      if (edit.name == own || !family_.is_significant(fit, edit.name) ||
          fit.sum_of_squares > options_.max_rival_ratio * present_.fit.sum_of_squares) {
        continue;
      }
      const Judged tried = judged(fit);
      if (is_better(tried)) {
        forget(own);
        selection_.steps.erase(selection_.steps.begin() + static_cast<std::ptrdiff_t>(at));
        take(tried, edit.name);
        return true;
      }
      if (is_rival(tried)) {
        add_rival(selection_.steps[at], edit.name, tried);
      }
    }
    return false;
  }

  void add_rival(SelectionStep& step, const std::string& name, const Judged& rival) {
    rivals_.push_back({name, rival.fit});
    const auto is_known = [&](const SelectionStep::RivalFit& one) { return one.name == name; };
    if (std::none_of(step.rivals.begin(), step.rivals.end(), is_known)) {
      step.rivals.push_back({name, rival.fit, rival.error / present_.error});
      selection_.not_separable.push_back({step.name, name});
    }
  }

  /// Adds an effect that the likelihood wants if both parts are predicted better with it, and if they give the evidence
  /// together that the training part must give for any effect.
  bool add(const std::string& name) {
    if (selection_.steps.size() >= options_.maximum_effects) {
      return false;
    }
    for (const Family::Edit& edit : family_.edits(present_.fit.structure)) {
      if (edit.name != name) {
        continue;
      }
      const Judged tried = judged(fitted(edit.structure));
      if (family_.is_significant(tried.fit, name) && tried.criterion < present_.criterion &&
          tried.error < (1.0 - options_.minimum_cv_gain) * present_.error &&
          convincing(evidence_of_both(present_.fit.structure, edit.structure), options_)) {
        forget(name);
        take(tried, name);
        return true;
      }
    }
    return false;
  }

  /// Drops what the selection said of alternatives with this effect.
  void forget(const std::string& name) {
    for (SelectionStep& step : selection_.steps) {
      std::erase_if(step.rivals, [&](const auto& one) { return one.name.find(name) != std::string::npos; });
    }
    std::erase_if(selection_.not_separable, [&](const auto& group) { return has(group, name); });
  }

  void take(const Judged& tried, const std::string& name) {
    present_ = tried;
    selection_.final_model = cross_validated_fit(family_, tried.fit.structure, &tried.fit, options_.folds);
    const Structure reduced = family_.without(tried.fit.structure, name);
    const CrossValidatedFit without = cross_validated_fit(family_, reduced, &tried.fit, options_.folds);
    const Comparison evidence =
        compare(without, selection_.final_model, samples_of(selection_.final_model.errors), problem_.start_samples());
    selection_.steps.push_back({name, evidence.cv_gain, evidence.delta_bic, evidence.t, {}});
  }

  /// Fits and evidence of both parts together, each part with its own fit.
  CrossValidatedFit in_both(const Structure& structure) const {
    const std::size_t folds = options_.folds;
    const Fit& present = selection_.final_model.fit;
    const AxisFamily& other = exchanged_->axis_family();
    const Fit start = other.with_parameters_of(present, family_.model(present));
    CrossValidatedFit out = cross_validated_fit(family_, structure, &present, folds);
    const CrossValidatedFit more = cross_validated_fit(other, structure, &start, folds);
    out.fit.sum_of_squares += more.fit.sum_of_squares;
    out.cv += more.cv;
    out.cv_block.insert(out.cv_block.end(), more.cv_block.begin(), more.cv_block.end());
    out.errors.insert(out.errors.end(), more.errors.begin(), more.errors.end());
    out.effective_samples = effective_sample_size(out.errors);
    return out;
  }

  Comparison evidence_of_both(const Structure& without, const Structure& with) const {
    const CrossValidatedFit more = in_both(with);
    return compare(in_both(without), more, samples_of(more.errors), problem_.start_samples());
  }

  /// Names a parameter that every model has where both parts together refute its declared value, and only there.
  void name_nuisances() {
    const Structure& declared = problem_.request().declared;
    for (const std::string& name : family_.completed(declared)) {
      const Structure present = selection_.final_model.fit.structure;
      const Structure reduced = family_.without(present, name);
      if (has(declared, name) || reduced == present) {
        continue;
      }
      const auto is_it = [&](const SelectionStep& step) { return step.name == name; };
      const Comparison evidence = evidence_of_both(reduced, present);
      const bool named = family_.is_significant(selection_.final_model.fit, name) && convincing(evidence, {});
      if (!named) {
        std::erase_if(selection_.steps, is_it);
      } else if (std::none_of(selection_.steps.begin(), selection_.steps.end(), is_it)) {
        selection_.steps.insert(selection_.steps.begin(), {name, evidence.cv_gain, evidence.delta_bic, evidence.t, {}});
      }
    }
  }

  const SelectionOptions options_;
  const AxisProblem& problem_;
  const AxisFamily& family_;
  Selection& selection_;
  FreeRun run_;
  std::unique_ptr<AxisProblem> exchanged_;  ///< the same log with training and validation exchanged
  Judged present_;
  std::vector<Rival> rivals_;  ///< of the effects of present_
};

}  // namespace

std::optional<WeakEffect> settle(const AxisProblem& problem, Selection& selection) {
  return CommonStructure(problem, selection).run();
}

}  // namespace m100::lab::identify
