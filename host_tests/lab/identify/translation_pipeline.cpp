// SPDX-License-Identifier: BSD-3-Clause
// Translation: from a log and a declared model to a verdict.
#include "host_tests/lab/identify/translation_pipeline.h"

#include <algorithm>
#include <memory>

#include "host_tests/lab/identify/data/translation_repair.h"
#include "host_tests/lab/identify/data/unit_consistency.h"
#include "host_tests/lab/identify/processor_time.h"
#include "host_tests/lab/identify/remainder.h"
#include "host_tests/lab/identify/selection/problem.h"
#include "host_tests/lab/identify/selection/regimes.h"
#include "host_tests/lab/identify/translation_problem.h"

namespace m100::lab::identify {
namespace {

using namespace translation;  // its own parts

constexpr double kMinimumCvGain = 0.03;  // the force residual has no memory, so less than on a stick axis is enough

/// Runs the tests of a repaired log in this order: structure, winds of the flights, force that depends on position,
/// change, and the structure again on one side of the change.
class TranslationPipeline {
 public:
  TranslationPipeline(const Request& request, SideFindings side_findings)
      : request_(request), side_findings_(std::move(side_findings)) {}

  /// @param misread_attitude  axes or signs of the log's attitude are wrong; no effect is then selected
  IdentifyResult run(bool misread_attitude) {
    options_.minimum_cv_gain = kMinimumCvGain;
    options_.maximum_effects = misread_attitude ? 0 : options_.maximum_effects;
    problem_ = std::make_unique<TranslationProblem>(request_, false);
    chosen_ = select_effects(*problem_, request_, options_);
    if (!misread_attitude) {
      fit_flight_winds();
      const std::vector<Finding> tether = problem_->tether(chosen_.final_model.fit);
      side_findings_.findings.insert(side_findings_.findings.end(), tether.begin(), tether.end());
      if (tether.empty()) {  // a force that depends on position looks like a change
        detect_change_point();
      }
    }
    return conclude(*problem_, side_ ? *side_ : request_, std::move(chosen_), std::move(side_findings_));
  }

 private:
  /// Fits a wind to each flight if the winds differ. The verdict can then be "nothing missing" only if steady_wind is
  /// in the model.
  void fit_flight_winds() {
    if (request_.log->flights.empty() || request_.wind_from_first_s > 0.0 ||
        !are_distinct(problem_->winds(chosen_.final_model.fit))) {
      return;
    }
    constexpr const char* kWind = "steady_wind";
    per_flight_winds_ = true;
    problem_ = std::make_unique<TranslationProblem>(request_, true);
    chosen_ = select_effects(*problem_, request_, options_);
    side_findings_.findings.push_back(note(describe(problem_->winds(chosen_.final_model.fit))));
    const auto& structure = chosen_.final_model.fit.structure;
    if (std::find(structure.begin(), structure.end(), kWind) == structure.end()) {
      side_findings_.unexplained.emplace_back("the winds differ from flight to flight; declare steady_wind");
    }
  }

  /// Searches for a change in flight. It must also be found with the structure that is selected on one side of it, if a
  /// side is long enough.
  void detect_change_point() {
    std::vector<Change> changes = problem_->changes(chosen_.final_model.fit);
    if (changes.empty()) {
      return;
    }
    auto regime = select_regime<TranslationProblem>(request_, changes.front(), options_, per_flight_winds_);
    if (regime) {
      changes = problem_->changes(regime->chosen.final_model.fit);
      if (changes.empty()) {
        return;
      }
      side_ = std::move(regime->request);
      problem_ = std::move(regime->problem);
      chosen_ = std::move(regime->chosen);
      side_findings_.findings.push_back(regime_note(*side_));
    }
    for (const Change& change : changes) {
      accept_change(change);
    }
  }

  /// Removes the changed effect from the named effects, and also any effect that these data cannot distinguish from it.
  void accept_change(const Change& change) {
    const std::string effect = change.name == "mass" ? "thrust_gain" : change.name;  // which acts in the same way
    const std::string equivalent(model::translation_effect(effect)->equivalent);
    const bool alike = std::any_of(chosen_.not_separable.begin(), chosen_.not_separable.end(), [&](const auto& group) {
      return std::find(group.begin(), group.end(), effect) != group.end() &&
             std::find(group.begin(), group.end(), equivalent) != group.end();
    });
    const auto same = [&](const std::string& name) { return name == effect || (alike && name == equivalent); };
    std::erase_if(chosen_.steps, [&](const SelectionStep& step) { return same(step.name); });
    std::erase_if(chosen_.not_separable,
                  [&](const auto& group) { return std::any_of(group.begin(), group.end(), same); });
    add_change(side_findings_, change);
  }

  const Request& request_;
  std::unique_ptr<Request> side_;  ///< the request of one side of a change; null: no side was selected
  bool per_flight_winds_ = false;  ///< the winds differ, so each flight has its own
  SelectionOptions options_;
  std::unique_ptr<TranslationProblem> problem_;
  Selection chosen_;
  SideFindings side_findings_;
};

}  // namespace

IdentifyResult identify_translation(const Request& request) {
  const double started_s = processor_s();
  SideFindings side_findings;
  const logs::FlightLog log = repaired(*request.log, requested_ranges(request, true), side_findings.findings);
  const bool one_log = in_one_log(request);
  const logs::FlightLog other =
      one_log ? logs::FlightLog{}
              : repaired(*request.validation_log, requested_ranges(request, false), side_findings.findings);
  Request cleaned = request;
  cleaned.log = &log;
  cleaned.validation_log = one_log ? &log : &other;
  const std::vector<Finding> units = unit_contradictions(log, request.axis, requested_ranges(request, true));
  side_findings.findings.insert(side_findings.findings.end(), units.begin(), units.end());
  const std::vector<Finding> signs = misread_attitude(log, request.train);
  side_findings.findings.insert(side_findings.findings.end(), signs.begin(), signs.end());
  IdentifyResult result = TranslationPipeline(cleaned, std::move(side_findings)).run(!signs.empty());
  result.remainder = remainder_curves(remainder_of(result), log);
  result.elapsed_s = processor_s() - started_s;
  return result;
}

}  // namespace m100::lab::identify
