// SPDX-License-Identifier: BSD-3-Clause
// The stick axes: from a log and a declared model to a verdict.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "host_tests/lab/identify/axis/axis_change.h"
#include "host_tests/lab/identify/axis/axis_change_again.h"
#include "host_tests/lab/identify/axis/axis_clock.h"
#include "host_tests/lab/identify/axis/axis_rest.h"
#include "host_tests/lab/identify/axis/axis_study.h"
#include "host_tests/lab/identify/axis/axis_tether.h"
#include "host_tests/lab/identify/axis/axis_trace.h"
#include "host_tests/lab/identify/axis/flight_trims.h"
#include "host_tests/lab/identify/axis/row_readings.h"
#include "host_tests/lab/identify/axis/stick_freeze.h"
#include "host_tests/lab/identify/processor_time.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/search/sides.h"
#include "host_tests/lab/identify/search/verdict.h"

namespace m100::lab::identify {
namespace {

/// The order of the tests of a log: clock before structure, structure before change.
class AxisInquiry {
 public:
  explicit AxisInquiry(const Request& request) : request_(request) { request_.asked = asked_of(request, true); }

  IdentifyResult run() {
    const double started_s = processor_s();
    study_ = std::make_unique<AxisStudy>(request_);
    const bool own_trims = request_.log->flights.size() > 1 && take_trims(declared_fit());
    chosen_ = choose(*study_, request_, {});
    if (own_trims &&
        take_trims(chosen_.final_model.fit)) {  // a dead zone hides trims: tested again under the selected model
      chosen_ = choose(*study_, request_, {});
    }
    if (own_trims) {
      beside_.findings.push_back(note(in_words(flight_trims_)));
    }
    if (!stick_froze()) {
      ask_the_clock();
      if (!pulled_back()) {
        ask_for_a_change();
      }
    }
    ask_for_trims();
    ask_between_rows();
    ask_for_traces();
    IdentifyResult result = conclude(*study_, study_->request(), std::move(chosen_), std::move(beside_));
    result.elapsed_s = processor_s() - started_s;
    return result;
  }

 private:
  Fit declared_fit() const {
    const AxisFamily& family = study_->axis_family();
    return family.fit(request_.declared, std::vector<int>(family.block_count(), 1), nullptr);
  }

  /// Gives each flight of a joined log its own trim where the trims differ. @returns whether this made a new study.
  bool take_trims(const Fit& fit) {
    std::vector<FlightTrim> more = flight_trims(*study_, fit);
    if (!(flight_trims_.empty() ? differ(*study_, more) : moved(*study_, more))) {
      return false;
    }
    std::vector<double> values;
    for (std::size_t k = 0; k < more.size(); ++k) {
      const double before = flight_trims_.empty() ? 0.0 : flight_trims_[k].size.value;
      more[k].size = {more[k].size.value + before, more[k].size.low + before, more[k].size.high + before};
      values.push_back(more[k].size.value);
    }
    flight_trims_ = std::move(more);
    trims_ = std::move(values);
    study_ = std::make_unique<AxisStudy>(request_, shift_s_, trims_);
    return true;
  }

  /// Tested first: a column that freezes while the hand moves on looks like a change, or like a clock shift.
  bool stick_froze() {
    const std::vector<Finding> found = stick_freeze({&study_->training(), &study_->validation()},
                                                    study_->axis_family().model(chosen_.final_model.fit));
    beside_.findings.insert(beside_.findings.end(), found.begin(), found.end());
    return !found.empty();
  }

  /// Neutral points that differ are an effect like any other. If it was neither declared nor named, it forbids a clean
  /// bill, although the trims were subtracted from the sticks.
  void ask_for_trims() {
    constexpr const char* kTrim = "trim_offset";
    const auto is_trim = [](const Step& step) { return step.name == kTrim; };
    const bool declared =
        std::find(request_.declared.begin(), request_.declared.end(), kTrim) != request_.declared.end();
    if (!flight_trims_.empty() && !declared && std::none_of(chosen_.steps.begin(), chosen_.steps.end(), is_trim)) {
      beside_.unexplained.emplace_back("the neutral points differ from flight to flight; declare trim_offset");
    }
  }

  /// A named effect must be certain for every reading of the stick between slow rows, by the selection's threshold for
  /// whitened residuals. Otherwise it loses its name and is reported as unexplained.
  void ask_between_rows() {
    const double least = SelectionOptions{}.least_delta_white;
    const AxisFamily& family = study_->axis_family();
    const Fit& fit = chosen_.final_model.fit;
    std::vector<std::string> open;
    for (const Step& step : chosen_.steps) {
      const double price = std::log(static_cast<double>(study_->free_run().size()));
      if (ratio_between_rows(study_->training().signals.data, study_->free_ranges(), family, fit, step.name) <
          least + price) {
        open.push_back(step.name);
      }
    }
    for (const std::string& name : open) {
      beside_.unexplained.push_back(name + " would fit, but the stick was logged too slowly to confirm it");
      forget(name);
    }
  }

  /// Tested last, where the result would otherwise be a clean bill.
  void ask_for_traces() {
    const bool clean = chosen_.steps.empty() && beside_.changes.empty() && beside_.unexplained.empty() &&
                       std::none_of(beside_.findings.begin(), beside_.findings.end(), forbids_clean_bill);
    if (!clean) {
      return;
    }
    RowReadings readings = readings_of(study_->training().signals.data, study_->free_ranges());
    const std::optional<AxisTrace> trace = trace_of(std::move(readings.runs), study_->training().signals.data,
                                                    study_->axis_family(), chosen_.final_model.fit);
    if (!trace) {
      return;
    }
    std::array<char, 200> text{};
    std::snprintf(
        text.data(), text.size(),
        "an effect like %s is certain (likelihood ratio %.0f above its penalty), but it explains too little of "
        "the residual to be named",
        trace->name.c_str(), trace->likelihood_ratio);
    beside_.unexplained.emplace_back(text.data());
  }

  /// Where the response begins before its stick, the sticks are shifted and the structure is selected again: the effect
  /// that explained the shift (mostly a lead zero) is no longer needed. The shift must still be there under the new
  /// structure.
  void ask_the_clock() {
    const ClockShift first = clock_of(study_->free_run(), study_->axis_family(), chosen_.final_model.fit);
    if (!first.likely) {
      doubt_the_zero(first);
      return;
    }
    auto moved = std::make_unique<AxisStudy>(request_, -first.shift_s, trims_);
    Selection chosen = choose(*moved, request_, {});
    const ClockShift clock = clock_of(study_->free_run(), moved->axis_family(), chosen.final_model.fit);
    if (!clock.likely) {
      doubt_the_zero(first);
      return;
    }
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(), "the response begins %.3f s (+-%.3f) before its stick: %s", -clock.shift_s,
                  2.0 * clock.sigma_s,
                  clock.certain ? "the clocks disagree; the stick samples were shifted"
                                : "the clocks may disagree, but these data cannot confirm it");
    beside_.findings.push_back(
        {.what = "clock_shift", .signal = moved->stick_name(), .text = text.data(), .certain = clock.certain});
    beside_.unexplained.emplace_back(text.data());
    shift_s_ = -first.shift_s;
    study_ = std::move(moved);
    chosen_ = std::move(chosen);
    forget("lead_zero");  // never beside a response that begins before its stick
  }

  /// Where rows are too slow to confirm a shift, they are too slow to name a lead zero, which may be caused by it.
  void doubt_the_zero(const ClockShift& clock) {
    constexpr const char* kZero = "lead_zero";
    const bool named =
        std::any_of(chosen_.steps.begin(), chosen_.steps.end(), [&](const Step& step) { return step.name == kZero; });
    if (clock.zero_in_doubt && named) {
      beside_.unexplained.emplace_back(
          "these data cannot distinguish a lead zero from a response that begins before its stick");
      forget(kZero);
    }
  }

  /// Tests for a climb speed that falls with the height flown, before a change, which it imitates. It is tested under
  /// the selected and under the declared model, because beside it the declared model may be complete.
  bool pulled_back() {
    if (request_.axis != "climb" || !study_->training().signals.data.other.empty()) {
      return false;
    }
    const AxisFamily& family = study_->axis_family();
    const auto under = [&](const Fit& fit) {
      return tether_of(study_->training().signals.data, study_->free_ranges(), family, fit);
    };
    std::optional<AxisTether> tether = under(chosen_.final_model.fit);
    if (!chosen_.steps.empty()) {
      const Fit& declared = chosen_.declared.fit;
      const Fit& found = chosen_.final_model.fit;
      const FreeRun run = study_->free_run();
      const double more = static_cast<double>(found.free_parameters) - static_cast<double>(declared.free_parameters);
      const double price = std::max(0.0, more) * std::log(static_cast<double>(run.size()));
      const std::optional<AxisTether> plain = under(declared);
      if (plain && plain->score < price + (tether ? tether->score : unchanged_score(run, family, found))) {
        tether = plain;
        chosen_.steps.clear();
        chosen_.not_separable.clear();
        chosen_.final_model = chosen_.declared;
      }
    }
    if (tether) {
      beside_.findings.push_back(tether_finding(*tether, study_->training().signals.response_name));
      beside_.unexplained.push_back(beside_.findings.back().text);
    }
    return tether.has_value();
  }

  /// A change must remain under the structure that is selected on one side of it.
  void ask_for_a_change() {
    FreeRun run = study_->free_run();
    weigh_by_what_is_known({&run, 1}, study_->training().signals.data,
                           study_->axis_family().model(chosen_.final_model.fit));
    const AxisChange first = change_under(run, chosen_);
    if (!first.found) {
      if (first.likely && chosen_.steps.empty() &&
          ratio_between_rows(study_->training().signals.data, study_->free_ranges(), study_->axis_family(),
                             chosen_.final_model.fit, first) >= kChangeIsChance) {
        doubt(first.change, "the change is too uncertain to be named and too likely for a clean bill");
      }
      return;
    }
    std::optional<CalmSide<AxisStudy>> calm = calm_side<AxisStudy>(request_, first.change, {}, shift_s_, trims_);
    if (!calm) {
      const AxisFamily& family = study_->axis_family();
      if (!constant_explains(run, family, chosen_.final_model.fit, first) &&
          believe(first, family, chosen_.final_model.fit)) {
        take(first.change);
      }
      return;
    }
    const Fit& fit = calm->chosen.final_model.fit;
    AxisChange change = change_of(run, calm->study->axis_family(), fit);
    add_the_other_tale(first, run, change);
    if (!change.found || constant_explains(run, calm->study->axis_family(), fit, change) ||
        !believe(change, calm->study->axis_family(), fit)) {
      return;
    }
    beside_.findings.push_back(side_note(*calm->request));
    study_ = std::move(calm->study);
    chosen_ = std::move(calm->chosen);
    take(change.change);
  }

  /// Whether an effect that never changes explains the log as well as the change. A date is free to be chosen, so a
  /// change that is not there wins up to kChangeIsChance by chance alone: a missing lead zero looks like a delay that
  /// changes where the hand becomes faster. A step of a trim is absorbed by the autoregression and cannot be compared.
  bool constant_explains(const FreeRun& run, const AxisFamily& family, const Fit& fit, const AxisChange& change) {
    if (change.knob.member == &model::StickAxis::trim_counts) {
      return false;
    }
    const std::vector<int> all(family.block_count(), 1);
    const double price = std::log(static_cast<double>(run.size()));
    for (const Family::Edit& edit : family.edits(fit.structure)) {
      const Fit constant = family.fit(edit.structure, all, &fit);
      const double more = static_cast<double>(constant.free_parameters) - static_cast<double>(fit.free_parameters);
      const double score = unchanged_score(run, family, constant) + std::max(0.0, more - 1.0) * price;
      if (score < change.score) {
        beside_.findings.push_back(note("a change of " + change.change.name + " would fit, but " + edit.name +
                                        ", which never changes, explains the log better"));
        return true;
      }
      if (score < change.score + kChangeIsChance) {
        const std::string why = edit.name + ", which never changes, explains the log as well";
        doubt(change.change, why.c_str());
        return true;
      }
    }
    return false;
  }

  /// An effect found on one side together with another change may explain the log as well as the first change alone.
  /// Unless they are clearly worth the penalty of their parameters, neither name is certain.
  static void add_the_other_tale(const AxisChange& first, const FreeRun& run, AxisChange& change) {
    const double more = static_cast<double>(change.numbers) - static_cast<double>(first.numbers);
    const double price = std::max(0.0, more) * std::log(static_cast<double>(run.size()));
    if (change.found && change.change.name != first.change.name && first.score < change.score + price + kNameMargin) {
      change.change.rivals.push_back(first.change.name);
    }
  }

  /// @returns false for a change that slow rows of the stick make uncertain, which is reported, or may have caused. A
  /// temporary change is reported beside the change.
  bool believe(const AxisChange& change, const AxisFamily& family, const Fit& fit) {
    const AxisData& data = study_->training().signals.data;
    const std::vector<Range> ranges = study_->free_ranges();
    const std::optional<Change> another = another_change(data, ranges, family, fit, change);
    if (another) {
      std::array<char, 120> text{};
      std::snprintf(text.data(), text.size(), "a temporary change: the response changes at %.1f s and again at %.1f s",
                    std::min(change.change.at_s, another->at_s), std::max(change.change.at_s, another->at_s));
      beside_.unexplained.emplace_back(text.data());
      return true;
    }
    const double ratio = ratio_between_rows(data, ranges, family, fit, change);
    if (ratio >= kChangeIsChance && ratio < kChangeIsCertain) {
      doubt(change.change, "the stick was logged too slowly to confirm it");
    }
    return ratio >= kChangeIsCertain;
  }

  void doubt(const Change& change, const char* why) {
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(), "something may have changed at %.1f s (%s would fit): %s", change.at_s,
                  change.name.c_str(), why);
    beside_.unexplained.emplace_back(text.data());
  }

  void take(const Change& change) {
    const std::string reason = no_flight_beside(*study_, request_, chosen_.final_model.fit, change);
    if (!reason.empty()) {
      beside_.unexplained.push_back(reason);
      return;
    }
    forget(change.name);
    add_change(beside_, change);
  }

  /// Removes the effect's name from the result; the model keeps the effect. It is reported as a change, as a clock
  /// shift or as unexplained instead.
  void forget(const std::string& name) {
    std::erase_if(chosen_.steps, [&](const Step& step) { return step.name == name; });
    std::erase_if(chosen_.not_separable,
                  [&](const auto& group) { return std::find(group.begin(), group.end(), name) != group.end(); });
  }

  /// The change under the final structure; or under the declared one, where the change explains more than all named
  /// effects.
  AxisChange change_under(const FreeRun& run, const Selection& chosen) const {
    const AxisFamily& family = study_->axis_family();
    AxisChange with_effects = change_of(run, family, chosen.final_model.fit);
    if (chosen.steps.empty()) {
      return with_effects;
    }
    const AxisChange plain = change_of(run, family, chosen.declared.fit);
    if (with_effects.found) {  // an effect with another change can imitate one change: the simpler explanation wins
      const double more = static_cast<double>(chosen.final_model.fit.free_parameters) -
                          static_cast<double>(chosen.declared.fit.free_parameters);
      const double price = std::max(0.0, more) * std::log(static_cast<double>(run.size()));
      return plain.found && plain.score < with_effects.score + price ? plain : with_effects;
    }
    constexpr double kBetter = 6.0;
    return plain.found && plain.score + kBetter < unchanged_score(run, family, chosen.final_model.fit) ? plain
                                                                                                       : with_effects;
  }

  Request request_;
  double shift_s_ = 0.0;
  std::vector<FlightTrim> flight_trims_;  ///< empty: the flights do not differ
  std::vector<double> trims_;             ///< their values
  std::unique_ptr<AxisStudy> study_;
  Selection chosen_;
  Beside beside_;
};

}  // namespace

IdentifyResult identify_axis(const Request& request) { return AxisInquiry(request).run(); }

}  // namespace m100::lab::identify
