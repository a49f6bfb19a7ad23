// SPDX-License-Identifier: BSD-3-Clause
// The stick axes: from a log and a declared model to a verdict.
#include "host_tests/lab/identify/axis_pipeline.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "host_tests/lab/identify/axis_problem.h"
#include "host_tests/lab/identify/common_structure.h"
#include "host_tests/lab/identify/model/axis/flight_trims.h"
#include "host_tests/lab/identify/processor_time.h"
#include "host_tests/lab/identify/remainder.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_tether.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_time_offset.h"
#include "host_tests/lab/identify/residual_tests/axis/change_point_checks.h"
#include "host_tests/lab/identify/residual_tests/axis/ground_check.h"
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"
#include "host_tests/lab/identify/residual_tests/axis/stick_freeze.h"
#include "host_tests/lab/identify/residual_tests/axis/stick_reading.h"
#include "host_tests/lab/identify/selection/regimes.h"
#include "host_tests/lab/identify/selection/verdict.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

/// Selects the structure of a log under its trims, and then runs the tests in order.
class AxisPipeline {
 public:
  explicit AxisPipeline(const Request& request) : request_(request) {
    request_.requested = requested_ranges(request, true);
  }

  IdentifyResult run() {
    const double started_s = processor_s();
    problem_ = std::make_unique<AxisProblem>(request_);
    const bool own_trims = request_.log->flights.size() > 1 && subtract_flight_trims(declared_fit());
    chosen_ = select_effects(*problem_, request_, {});
    if (own_trims) {
      if (subtract_flight_trims(chosen_.final_model.fit)) {  // a dead zone hides trims: tested again
        chosen_ = select_effects(*problem_, request_, {});
      }
      side_findings_.findings.push_back(note(describe(flight_trims_)));
    }
    for (const auto search :
         {&AxisPipeline::detect_stick_freeze, &AxisPipeline::detect_other_stick, &AxisPipeline::detect_time_offset,
          &AxisPipeline::detect_tether, &AxisPipeline::settle_names, &AxisPipeline::detect_change_point}) {
      if (!has_other_cause_) {
        (this->*search)();
      }
    }
    check_flight_trims();
    withdraw_unconfirmed_effects();
    report_weak_effect();
    draw_remainder(*problem_, chosen_.final_model.fit, *request_.log, side_findings_);
    IdentifyResult result = conclude(*problem_, problem_->request(), std::move(chosen_), std::move(side_findings_));
    result.elapsed_s = processor_s() - started_s;
    return result;
  }

 private:
  /// Whether the log or its trims already forbid a clean bill.
  bool is_doubted() const {
    return !side_findings_.unexplained.empty() || std::ranges::any_of(side_findings_.findings, forbids_nothing_missing);
  }

  Fit declared_fit() const {
    const AxisFamily& family = problem_->axis_family();
    return family.fit(family.completed(request_.declared), std::vector<int>(family.block_count(), 1), nullptr);
  }

  /// If the trims of the flights differ, subtracts them from the sticks. @returns whether this made a new problem.
  bool subtract_flight_trims(const Fit& fit) {
    std::vector<FlightTrim> more = flight_trims(*problem_, fit);
    if (!(flight_trims_.empty() ? are_distinct(*problem_, more) : moved(*problem_, more))) {
      return false;
    }
    trims_.clear();
    for (std::size_t k = 0; k < more.size(); ++k) {
      const double before = flight_trims_.empty() ? 0.0 : flight_trims_[k].size.value;
      more[k].size = {more[k].size.value + before, more[k].size.low + before, more[k].size.high + before};
      trims_.push_back(more[k].size.value);
    }
    flight_trims_ = std::move(more);
    problem_ = std::make_unique<AxisProblem>(request_, clock_, trims_);
    return true;
  }

  /// Tests for a stick column that freezes while the hand moves on, which looks like a wrong clock or a change.
  void detect_stick_freeze() {
    const AxisFamily& family = problem_->axis_family();
    const Fit& fit = chosen_.final_model.fit;
    const Fit beside = family.fit(fit.structure, weights_beside_suspect(problem_->training(), family.model(fit)), &fit);
    const std::vector<Finding> found =
        stick_freeze({&problem_->training(), &problem_->validation()}, family.model(beside));
    if (!found.empty() && request_.acts(SpecialTest::kFrozenStick)) {
      side_findings_.findings.insert(side_findings_.findings.end(), found.begin(), found.end());
      has_other_cause_ = true;
    }
  }

  /// Tests whether the vehicle received another stick than the logged one. If the clocks run apart, the sticks are read
  /// by the other clock, and the structure is selected again.
  void detect_other_stick() {
    const AxisData& data = problem_->training().signals.data;
    const AxisFamily& family = problem_->axis_family();
    const std::string coarse = coarse_stick(data, problem_->free_ranges(), family, chosen_.final_model.fit);
    const std::optional<ClockRate> clock =
        coarse.empty() ? clock_rate(data, problem_->free_ranges(), family, chosen_.final_model.fit) : std::nullopt;
    if (!request_.acts(SpecialTest::kClock)) {
      return;
    }
    if (!coarse.empty()) {
      side_findings_.unexplained.push_back(problem_->stick_name() + coarse);
      withdraw(chosen_, "lead_zero");  // a held stick is late, and the response seems to begin before it
      has_other_cause_ = true;
    } else if (clock) {
      clock_.rate = clock->rate;
      problem_ = std::make_unique<AxisProblem>(request_, clock_, trims_);
      chosen_ = select_effects(*problem_, request_, {});
      const std::string text = describe(*clock);
      side_findings_.findings.push_back({.what = "clock_shift", .signal = problem_->stick_name(), .text = text});
      side_findings_.unexplained.push_back(text);
    }
  }

  /// Lets both parts of the log settle the names, unless the log itself is in doubt.
  void settle_names() {
    if (!is_doubted() && request_.acts(SpecialTest::kBothParts)) {
      lacking_ = settle(*problem_, chosen_);
    }
  }

  /// Reports trims that differ between flights as unexplained, unless trim_offset was declared or named. The verdict
  /// cannot be "nothing missing" then, although the trims were subtracted from the sticks.
  void check_flight_trims() {
    const auto is_trim = [](const SelectionStep& step) { return step.name == "trim_offset"; };
    if (!flight_trims_.empty() && !has(request_.declared, "trim_offset") &&
        std::ranges::none_of(chosen_.steps, is_trim)) {
      side_findings_.unexplained.emplace_back("the neutral points differ from flight to flight; declare trim_offset");
    }
  }

  /// Reports a named effect as unexplained instead if its likelihood ratio is too small under any hypothesis about the
  /// motion of an undersampled stick.
  void withdraw_unconfirmed_effects() {
    const double minimum = SelectionOptions{}.min_delta_white + price_of(1, 0, problem_->free_run());
    std::vector<std::string> open;
    for (const SelectionStep& step : chosen_.steps) {
      if (min_ratio_over_hypotheses(problem_->training().signals.data, problem_->free_ranges(), problem_->axis_family(),
                                    chosen_.final_model.fit, step.name) < minimum &&
          request_.acts(SpecialTest::kSlowStick)) {
        open.push_back(step.name);
      }
    }
    for (const std::string& name : open) {
      side_findings_.unexplained.push_back(name + " would fit, but the stick was logged too slowly to confirm it");
      withdraw(chosen_, name);
    }
  }

  /// Reports an effect that the final model lacks with certainty, but that is too small to be named. It is not reported
  /// where the verdict is already "unexplained".
  void report_weak_effect() {
    if (lacking_ && !is_doubted() && request_.acts(SpecialTest::kWeakEffect)) {
      side_findings_.unexplained.push_back(printed(
          "an effect like %s is certain (likelihood ratio %.0f), but it explains too little of the residual to be "
          "named",
          lacking_->name.c_str(), lacking_->likelihood_ratio));
    }
  }

  /// If the response begins before its stick, the sticks are shifted and the structure is selected again: the shift may
  /// have been imitated by an effect, mostly a lead zero. A shift beyond the time between two rows must also be found
  /// with the new structure.
  void detect_time_offset() {
    const TimeOffset first = time_offset(problem_->free_run(), problem_->axis_family(), chosen_.final_model.fit);
    if ((!first.likely && !first.within_row) || !request_.acts(SpecialTest::kClock)) {
      withdraw_doubtful_lead_zero(first);
      return;
    }
    const StickClock shifted{-first.shift_s, clock_.rate};
    auto moved = std::make_unique<AxisProblem>(request_, shifted, trims_);
    Selection chosen = select_effects(*moved, request_, {});
    const TimeOffset clock =
        first.within_row ? first : time_offset(problem_->free_run(), moved->axis_family(), chosen.final_model.fit);
    if (!first.within_row && !clock.likely) {
      withdraw_doubtful_lead_zero(first);
      return;
    }
    clock_ = shifted;
    problem_ = std::move(moved);
    chosen_ = std::move(chosen);
    if (first.within_row) {
      side_findings_.findings.push_back(
          note("the response begins before its stick by less than the time between two rows: the stick samples were "
               "shifted"));
      withdraw_doubtful_lead_zero(first);
      return;
    }
    const std::string text = describe(clock);
    side_findings_.findings.push_back(
        {.what = "clock_shift", .signal = problem_->stick_name(), .text = text, .certain = clock.certain});
    side_findings_.unexplained.push_back(text);
    withdraw(chosen_, "lead_zero");  // a response that begins before its stick imitates it
  }

  /// Removes the name of a lead zero if the rows of the log are too slow to distinguish it from a time shift.
  void withdraw_doubtful_lead_zero(const TimeOffset& clock) {
    const bool named =
        std::ranges::any_of(chosen_.steps, [](const SelectionStep& step) { return step.name == "lead_zero"; });
    if (!clock.zero_in_doubt || !named || !request_.acts(SpecialTest::kZeroOrClock)) {
      return;
    }
    if (sharpens_rows(problem_->training().signals.data, problem_->axis_family().model(chosen_.final_model.fit))) {
      side_findings_.findings.push_back(note("the lead zero compensates for the slow rows of the stick"));
    } else {
      side_findings_.unexplained.emplace_back(
          "these data cannot distinguish a lead zero from a response that begins before its stick");
    }
    withdraw(chosen_, "lead_zero");
  }

  /// Tests for a climb speed that falls with the height flown, with the selected model and with the declared one,
  /// because the selected effects may imitate a tether.
  void detect_tether() {
    if (request_.axis != "climb" || !problem_->training().signals.data.other.empty()) {
      return;
    }
    const AxisFamily& family = problem_->axis_family();
    const auto under = [&](const Fit& fit) {
      return detect_tether_force(problem_->training().signals.data, problem_->free_ranges(), family, fit);
    };
    std::optional<AxisTether> tether = under(chosen_.final_model.fit);
    bool instead_of_effects = false;
    if (!chosen_.steps.empty()) {
      const Fit& declared = chosen_.declared.fit;
      const Fit& found = chosen_.final_model.fit;
      const FreeRun run = problem_->free_run();
      const double price = price_of(found.free_parameters, declared.free_parameters, run);
      const std::optional<AxisTether> plain = under(declared);
      if (plain && plain->score < price + (tether ? tether->score : unchanged_fit(run, family, found).score)) {
        tether = plain;
        instead_of_effects = true;
      }
    }
    if (tether && request_.acts(SpecialTest::kTether)) {
      if (instead_of_effects) {
        chosen_.steps.clear();
        chosen_.not_separable.clear();
        chosen_.final_model = chosen_.declared;
      }
      side_findings_.findings.push_back(tether_finding(*tether, problem_->training().signals.response_name));
      side_findings_.unexplained.push_back(side_findings_.findings.back().text);
      has_other_cause_ = true;
    }
  }

  /// Searches for a change in flight. It must also be found with the structure that is selected on one side of it, if a
  /// side is long enough.
  void detect_change_point() {
    FreeRun run = problem_->free_run();
    weight_by_input_uncertainty(run, problem_->axis_family().model(chosen_.final_model.fit));
    const ChangePoint first = change_point_under(run, chosen_);
    if (!(first.found || first.likely) || !request_.acts(SpecialTest::kChange)) {
      return;
    }
    std::optional<Regime<AxisProblem>> regime =
        first.found && request_.acts(SpecialTest::kOneSide)
            ? select_regime<AxisProblem>(request_, first.change, {}, clock_, trims_)
            : std::nullopt;
    const AxisFamily& family = (regime ? regime->problem : problem_)->axis_family();
    const std::optional<WeakEffect> lacking = regime ? settle(*regime->problem, regime->chosen) : lacking_;
    const Fit& fit = (regime ? regime->chosen : chosen_).final_model.fit;
    ChangePoint change = first;
    if (regime) {
      change = change_point(run, family, fit);
      add_rival_change(first, run, change);
    }
    if (!confirm_change_point(run, change, family, fit)) {
      return;
    }
    if (regime) {
      side_findings_.findings.push_back(regime_note(*regime->request));
      problem_ = std::move(regime->problem);
      chosen_ = std::move(regime->chosen);
    }
    lacking_ = regime ? lacking : std::nullopt;  // across a change that neither side explains alone, nothing is certain
    accept_change(change.change);
  }

  /// Whether another effect, without a date, explains the log as well as the change. Its score may be worse by
  /// kChanceChange: the date of a change is free, which gains as much by chance. A change of the trim is not compared.
  bool constant_explains(const FreeRun& run, const AxisFamily& family, const Fit& fit, const ChangePoint& change) {
    if (change.free_parameter.member == &model::StickAxis::trim_counts || !request_.acts(SpecialTest::kConstant)) {
      return false;
    }
    const std::vector<int> all(family.block_count(), 1);
    for (const Family::Edit& edit : family.edits(fit.structure)) {
      const Fit constant = family.fit(edit.structure, all, &fit);
      const double score =
          unchanged_fit(run, family, constant).score + price_of(constant.free_parameters, fit.free_parameters + 1, run);
      if (score < change.score) {
        side_findings_.findings.push_back(note("a change of " + change.change.name + " would fit, but " + edit.name +
                                               ", which has no date, explains the log better"));
        return true;
      }
      if (score < change.score + kChanceChange) {
        report_uncertain_change(change.change, edit.name + ", which has no date, explains the log as well");
        return true;
      }
    }
    return false;
  }

  /// Whether the change may be named: no effect without a date explains it, and it is temporary, or certain under every
  /// hypothesis about an undersampled stick and without a burst beside it. A temporary change is also reported as
  /// unexplained, and so is one that is likely but not certain.
  bool confirm_change_point(const FreeRun& run, const ChangePoint& change, const AxisFamily& family, const Fit& fit) {
    const AxisData& data = problem_->training().signals.data;
    const std::vector<Range> ranges = problem_->free_ranges();
    if (!change.found) {
      if (change.likely && min_ratio_over_hypotheses(data, ranges, family, fit, change) >= kChanceChange) {
        report_uncertain_change(change.change,
                                "the change is too uncertain to be named and too likely for \"nothing missing\"");
      }
      return false;
    }
    if (constant_explains(run, family, fit, change)) {
      return false;
    }
    const std::optional<Change> another = second_change_point(data, ranges, family, fit, change);
    if (another && request_.acts(SpecialTest::kTemporary)) {
      side_findings_.unexplained.push_back(
          printed("a temporary change: the response changes at %.1f s and again at %.1f s",
                  std::min(change.change.at_s, another->at_s), std::max(change.change.at_s, another->at_s)));
      return true;
    }
    const std::optional<double> burst_s = burst_beside(run, change);
    const double ratio = min_ratio_over_hypotheses(data, ranges, family, fit, change);
    if (ratio >= kChanceChange && (burst_s || ratio < kCertainChange)) {
      report_uncertain_change(change.change, burst_s ? printed("it leaves a burst at %.1f s", *burst_s)
                                                     : "the stick was logged too slowly to confirm it");
    }
    return !burst_s && ratio >= kCertainChange;
  }

  void report_uncertain_change(const Change& change, const std::string& why) {
    side_findings_.unexplained.push_back(printed("something may have changed at %.1f s (%s would fit): %s", change.at_s,
                                                 change.name.c_str(), why.c_str()));
  }

  void accept_change(const Change& change) {
    const std::string reason = ground_reason(*problem_, request_, chosen_.final_model.fit, change);
    if (reason.empty()) {
      withdraw(chosen_, change.name);
      add_change(side_findings_, change);
    } else {
      side_findings_.unexplained.push_back(reason);
    }
  }

  /// The change found with the final structure. The one found with the declared structure is returned instead if it
  /// explains the log better than the named effects, with a penalty for the number of parameters.
  ChangePoint change_point_under(const FreeRun& run, const Selection& chosen) const {
    const AxisFamily& family = problem_->axis_family();
    ChangePoint with_effects = change_point(run, family, chosen.final_model.fit);
    if (chosen.steps.empty()) {
      return with_effects;
    }
    const ChangePoint plain = change_point(run, family, chosen.declared.fit);
    if (with_effects.found) {  // an effect with another change can imitate one change: the simpler explanation wins
      const double price = price_of(chosen.final_model.fit.free_parameters, chosen.declared.fit.free_parameters, run);
      return plain.found && plain.score < with_effects.score + price ? plain : with_effects;
    }
    return plain.found && plain.score + kNameMargin < unchanged_fit(run, family, chosen.final_model.fit).score
               ? plain
               : with_effects;
  }

  Request request_;
  StickClock clock_;
  std::vector<FlightTrim> flight_trims_;  ///< empty: the flights do not differ
  std::vector<double> trims_;             ///< the values of flight_trims_, in the unit of the stick
  std::unique_ptr<AxisProblem> problem_;
  Selection chosen_;
  std::optional<WeakEffect> lacking_;  ///< a certain effect that the final model lacks
  bool has_other_cause_ = false;       ///< a test found what makes the later searches for effects meaningless
  SideFindings side_findings_;
};

}  // namespace

IdentifyResult identify_axis(const Request& request) { return AxisPipeline(request).run(); }

}  // namespace m100::lab::identify
