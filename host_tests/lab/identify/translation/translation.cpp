// SPDX-License-Identifier: BSD-3-Clause
// Translation: from a log and a declared model to a verdict.
#include <algorithm>
#include <memory>

#include "host_tests/lab/identify/log_defects.h"
#include "host_tests/lab/identify/log_units.h"
#include "host_tests/lab/identify/processor_time.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/search/sides.h"
#include "host_tests/lab/identify/search/study.h"
#include "host_tests/lab/identify/translation/translation_repair.h"
#include "host_tests/lab/identify/translation/translation_study.h"

namespace m100::lab::identify {
namespace {

using namespace translation;  // its own parts

constexpr double kMinimumCvGain = 0.03;  // the force residual has no memory, so less than on a stick axis is enough

/// The order of the tests of a log: its defects, structure, force that depends on position, change, and the structure
/// again on one side of the change.
class TranslationInquiry {
 public:
  TranslationInquiry(const Request& request, Beside beside) : request_(request), beside_(std::move(beside)) {}

  /// @param misread  the log's axes or signs are wrong, so every fitted effect would be caused by that
  IdentifyResult run(bool misread) {
    options_.minimum_cv_gain = kMinimumCvGain;
    options_.maximum_effects = misread ? 0 : options_.maximum_effects;
    study_ = std::make_unique<TranslationStudy>(request_, false);
    chosen_ = choose(*study_, request_, options_);
    if (!misread) {
      ask_for_winds();
      const std::vector<Finding> tether = study_->tether(chosen_.final_model.fit);
      beside_.findings.insert(beside_.findings.end(), tether.begin(), tether.end());
      if (tether.empty()) {  // a force that depends on position looks like a change
        ask_for_a_change();
      }
    }
    return conclude(*study_, side_ ? *side_ : request_, std::move(chosen_), std::move(beside_));
  }

 private:
  /// Flights may have different winds. Winds that differ are an effect like any other: if it was neither declared nor
  /// named, it forbids a clean bill, although the winds were fitted.
  void ask_for_winds() {
    if (request_.log->flights.empty() || request_.wind_from_first_s > 0.0 ||
        !differ(study_->winds(chosen_.final_model.fit))) {
      return;
    }
    constexpr const char* kWind = "steady_wind";
    own_winds_ = true;
    study_ = std::make_unique<TranslationStudy>(request_, true);
    chosen_ = choose(*study_, request_, options_);
    beside_.findings.push_back(note(in_words(study_->winds(chosen_.final_model.fit))));
    const auto& structure = chosen_.final_model.fit.structure;
    if (std::find(structure.begin(), structure.end(), kWind) == structure.end()) {
      beside_.unexplained.emplace_back("the winds differ from flight to flight; declare steady_wind");
    }
  }

  /// A change must remain under the structure that is selected on one side of it.
  void ask_for_a_change() {
    std::vector<Change> changes = study_->changes(chosen_.final_model.fit);
    if (changes.empty()) {
      return;
    }
    auto calm = calm_side<TranslationStudy>(request_, changes.front(), options_, own_winds_);
    if (calm) {
      changes = study_->changes(calm->chosen.final_model.fit);
      if (changes.empty()) {
        return;
      }
      side_ = std::move(calm->request);
      study_ = std::move(calm->study);
      chosen_ = std::move(calm->chosen);
      beside_.findings.push_back(side_note(*side_));
    }
    for (const Change& change : changes) {
      take(change);
    }
  }

  /// Removes the changed effect from the named effects, and also any effect that these data cannot distinguish from it.
  void take(const Change& change) {
    const std::string effect = change.name == "mass" ? "thrust_gain" : change.name;  // with the same signature
    const std::string twin(model::translation_effect(effect)->twin);
    const bool alike = std::any_of(chosen_.not_separable.begin(), chosen_.not_separable.end(), [&](const auto& group) {
      return std::find(group.begin(), group.end(), effect) != group.end() &&
             std::find(group.begin(), group.end(), twin) != group.end();
    });
    const auto same = [&](const std::string& name) { return name == effect || (alike && name == twin); };
    std::erase_if(chosen_.steps, [&](const Step& step) { return same(step.name); });
    std::erase_if(chosen_.not_separable,
                  [&](const auto& group) { return std::any_of(group.begin(), group.end(), same); });
    add_change(beside_, change);
  }

  const Request& request_;
  std::unique_ptr<Request> side_;  ///< of the change, where one was found
  bool own_winds_ = false;         ///< the flights differ
  SelectionOptions options_;
  std::unique_ptr<TranslationStudy> study_;
  Selection chosen_;
  Beside beside_;
};

}  // namespace

IdentifyResult identify_translation(const Request& request) {
  const double started_s = processor_s();
  Beside beside;
  const logs::FlightLog log = repaired(*request.log, asked_of(request, true), beside.findings);
  const bool one_log = in_one_log(request);
  const logs::FlightLog other =
      one_log ? logs::FlightLog{} : repaired(*request.validation_log, asked_of(request, false), beside.findings);
  Request cleaned = request;
  cleaned.log = &log;
  cleaned.validation_log = one_log ? &log : &other;
  const std::vector<Finding> units = unit_contradictions(log, request.axis, asked_of(request, true));
  beside.findings.insert(beside.findings.end(), units.begin(), units.end());
  const std::vector<Finding> signs = misread(log, request.train);
  beside.findings.insert(beside.findings.end(), signs.begin(), signs.end());
  IdentifyResult result = TranslationInquiry(cleaned, std::move(beside)).run(!signs.empty());
  result.elapsed_s = processor_s() - started_s;
  return result;
}

}  // namespace m100::lab::identify
