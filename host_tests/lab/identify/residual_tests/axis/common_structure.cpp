// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/common_structure.h"

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

class CommonStructure {
 public:
  CommonStructure(const AxisProblem& problem, Selection& selection)
      : problem_(problem), family_(problem.axis_family()), selection_(selection), run_(problem.free_run()) {}

  std::optional<WeakEffect> run() {
    lacking_ = search(selection_.final_model.fit);
    for (std::size_t round = 0; lacking_ && round < SelectionOptions{}.maximum_effects && place(); ++round) {
      lacking_ = search(selection_.final_model.fit);
    }
    if (exchanged() != nullptr) {
      name_nuisances();
    }
    return lacking_;
  }

 private:
  std::optional<WeakEffect> search(const Fit& fit) const {
    return weak_effect(problem_.training().signals.data, problem_.free_ranges(), family_, fit);
  }

  /// The same log with training and validation exchanged; null if the validation part does not allow a fit.
  const AxisProblem* exchanged() {
    if (!exchanged_ && in_one_log(problem_.request())) {
      try {
        exchanged_ = problem_.exchanged();
      } catch (const InputError&) {
      }
    }
    return exchanged_.get();
  }

  /// Sum of squares of both parts, each predicted by a fit to the other. Precondition: exchanged() is not null.
  double unseen_error(const Fit& fit) const {
    const AxisFamily& other = exchanged_->axis_family();
    const Fit start = other.with_parameters_of(fit, family_.model(fit));
    const Fit fitted = other.fit(fit.structure, std::vector<int>(other.block_count(), 1), &start);
    return lagged_product(problem_.validation_errors(fit), 0) +
           lagged_product(exchanged_->validation_errors(fitted), 0);
  }

  /// Schwarz's criterion of both parts.
  double criterion(const Fit& fit) const {
    return unchanged_score(run_, family_, fit) +
           static_cast<double>(fit.free_parameters) * std::log(static_cast<double>(run_.size()));
  }

  /// A model with the lacking effect, beside the present ones (`at` is their number) or in the place of one of them.
  struct Placed {
    std::size_t at = 0;
    CrossValidatedFit model;
    double criterion = 0.0;
    double error = 0.0;  ///< unseen_error()
  };

  std::vector<Placed> placements(const std::string& name) const {
    const SelectionOptions options;
    const CrossValidatedFit& present = selection_.final_model;
    std::vector<Placed> out;
    for (std::size_t at = 0; at <= selection_.steps.size(); ++at) {
      const bool adds = at == selection_.steps.size();
      const Structure reduced =
          adds ? present.fit.structure : family_.without(present.fit.structure, selection_.steps[at].name);
      if (adds ? at >= options.maximum_effects : reduced == present.fit.structure) {
        continue;
      }
      for (const Family::Edit& edit : family_.edits(reduced)) {
        if (edit.name == name) {
          Placed one{at, cross_validated_fit(family_, edit.structure, &present.fit, options.folds)};
          if (family_.is_significant(one.model.fit, name)) {
            one.criterion = criterion(one.model.fit) + (adds ? options.minimum_delta_bic : 0.0);
            one.error = unseen_error(one.model.fit);
            out.push_back(std::move(one));
          }
        }
      }
    }
    return out;
  }

  /// @returns whether the effect found a place; if it is only not separable from another one, lacking_ becomes what the
  /// model with it lacks.
  bool place() {
    if (exchanged() == nullptr) {
      return false;
    }
    const SelectionOptions options;
    const double criterion_now = criterion(selection_.final_model.fit);
    const double error_now = unseen_error(selection_.final_model.fit);
    const Placed* best = nullptr;
    const Placed* rival = nullptr;
    std::vector<Placed> all = placements(lacking_->name);
    for (const Placed& one : all) {
      if (one.criterion >= criterion_now) {
        continue;
      }
      const bool adds = one.at == selection_.steps.size();
      const double most = adds ? 1.0 - options.minimum_cv_gain : 1.0 + options.simpler_margin;
      if (one.error < most * error_now) {
        best = best == nullptr || one.criterion < best->criterion ? &one : best;
      } else if (!adds && one.error < (1.0 + options.rival_margin) * (1.0 + options.rival_margin) * error_now) {
        rival = rival == nullptr || one.criterion < rival->criterion ? &one : rival;
      }
    }
    if (best != nullptr) {
      accept(*best);
    } else if (rival != nullptr) {
      SelectionStep& step = selection_.steps[rival->at];
      const auto is_known = [&](const SelectionStep::RivalFit& one) { return one.name == lacking_->name; };
      if (std::none_of(step.rivals.begin(), step.rivals.end(), is_known)) {
        step.rivals.push_back({lacking_->name, rival->model.fit, rival->error / error_now});
        selection_.not_separable.push_back({step.name, lacking_->name});
      }
      lacking_ = search(rival->model.fit);
    }
    return best != nullptr;
  }

  void accept(const Placed& placed) {
    const std::string name = lacking_->name;
    for (SelectionStep& step : selection_.steps) {  // the effect stands beside them now, not in their place
      std::erase_if(step.rivals,
                    [&](const SelectionStep::RivalFit& one) { return one.name.find(name) != std::string::npos; });
    }
    std::erase_if(selection_.not_separable,
                  [&](const auto& group) { return std::find(group.begin(), group.end(), name) != group.end(); });
    if (placed.at < selection_.steps.size()) {
      const std::string old = selection_.steps[placed.at].name;
      std::erase_if(selection_.not_separable,
                    [&](const auto& group) { return std::find(group.begin(), group.end(), old) != group.end(); });
      selection_.steps.erase(selection_.steps.begin() + static_cast<std::ptrdiff_t>(placed.at));
    }
    const Fit& fit = placed.model.fit;
    const CrossValidatedFit without =
        cross_validated_fit(family_, family_.without(fit.structure, name), &fit, SelectionOptions{}.folds);
    const Comparison evidence =
        compare(without, placed.model, samples_of(placed.model.errors), problem_.start_samples());
    selection_.steps.push_back({name, evidence.cv_gain, evidence.delta_bic, evidence.t, {}});
    selection_.final_model = placed.model;
  }

  /// Fits and evidence of both parts together, each part with its own fit.
  CrossValidatedFit in_both(const Structure& structure) const {
    const std::size_t folds = SelectionOptions{}.folds;
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
      const CrossValidatedFit with = in_both(present);
      const CrossValidatedFit without = in_both(reduced);
      const Comparison evidence = compare(without, with, samples_of(with.errors), problem_.start_samples());
      const bool named = family_.is_significant(selection_.final_model.fit, name) && convincing(evidence, {});
      if (!named) {
        std::erase_if(selection_.steps, is_it);
      } else if (std::none_of(selection_.steps.begin(), selection_.steps.end(), is_it)) {
        selection_.steps.insert(selection_.steps.begin(), {name, evidence.cv_gain, evidence.delta_bic, evidence.t, {}});
      }
    }
  }

  const AxisProblem& problem_;
  const AxisFamily& family_;
  Selection& selection_;
  FreeRun run_;
  std::unique_ptr<AxisProblem> exchanged_;
  std::optional<WeakEffect> lacking_;
};

}  // namespace

std::optional<WeakEffect> settle(const AxisProblem& problem, Selection& selection) {
  return CommonStructure(problem, selection).run();
}

}  // namespace m100::lab::identify
