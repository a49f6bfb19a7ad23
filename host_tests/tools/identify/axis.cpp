// SPDX-License-Identifier: BSD-3-Clause
// The stick axes: from a log and a declared model to a verdict.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "host_tests/tools/identify/axis_family.h"
#include "host_tests/tools/identify/axis_signals.h"
#include "host_tests/tools/identify/bootstrap.h"
#include "host_tests/tools/identify/log_defects.h"
#include "host_tests/tools/identify/request.h"
#include "host_tests/tools/identify/residual_test.h"
#include "host_tests/tools/identify/selection.h"
#include "host_tests/tools/input_error.h"

namespace m100::tools::identify {
namespace {

constexpr std::size_t kLeastBlocks = 4;
constexpr double kHardlyFollows = 50.0;  // fit [%] below which the stick is not what moves the response
constexpr double kPoorFit = 80.0;        // fit [%] and
constexpr double kLittle = 0.25;         // share of the mean square below which a name beside a remainder is a guess
constexpr double kHeld_s = 0.045;
constexpr double kCutShare = 0.2;        // of the time at the stops
constexpr double kPrecedenceGain = 0.2;  // of the mean square, for a stick moved earlier
constexpr double kSettle_s = 1.0;        // a free run forgets its start within this time
const std::vector<double> kHorizons_s{0.2, 0.5, 1.0, 2.0};

/// One log with its axis, its ranges and its blocks.
struct Part {
  Part(const logs::FlightLog& flight_log, const std::string& axis, const std::vector<Range>& given)
      : log(flight_log), signals(axis_signals(flight_log, axis)), ranges(given), blocks(signals.data, given) {}
  Part(const Part&) = delete;
  const logs::FlightLog& log;
  AxisSignals signals;
  std::vector<Range> ranges;
  AxisBlocks blocks;
};

void check_declared(const std::vector<std::string>& declared) {
  if (declared.empty() || (declared[0] != "first_order" && declared[0] != "second_order")) {
    throw InputError("--declare", 0, declared.empty() ? "" : declared[0],
                     "the first name must be first_order or second_order");
  }
  for (std::size_t i = 1; i < declared.size(); ++i) {
    if (!AxisFamily::knows(declared[i]) || declared[i] == "first_order" || declared[i] == "second_order") {
      throw InputError("--declare", 0, declared[i], "not an effect of a stick axis");
    }
  }
}

void check_moved(const Part& part, const char* option) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double largest = 0.0;
  double response_low = low;
  double response_high = -low;
  for (std::size_t block = 0; block < part.blocks.size(); ++block) {
    for (std::size_t i = part.blocks[block].begin; i < part.blocks[block].end; ++i) {
      low = std::min(low, part.signals.data.stick[i]);
      high = std::max(high, part.signals.data.stick[i]);
      response_low = std::min(response_low, part.signals.data.measured[i]);
      response_high = std::max(response_high, part.signals.data.measured[i]);
    }
  }
  for (const double value : part.signals.data.stick) {
    largest = std::max(largest, std::abs(value));
  }
  const double least = largest > 5.0 ? 10.0 : 0.01;
  if (part.blocks.size() > 0 && !(high - low > least)) {
    throw InputError(part.log.file, 0, part.signals.stick_name,
                     std::string("the stick was never moved in the ") + option + " ranges");
  }
  if (part.blocks.size() > 0 && !(response_high > response_low)) {
    throw InputError(part.log.file, 0, part.signals.stick_name,
                     std::string("the response is one constant in the ") + option + " ranges");
  }
}

void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more) {
  if (into.empty()) {
    into = std::move(more);
    return;
  }
  for (std::size_t group = 0; group < into.size(); ++group) {
    for (std::size_t k = 0; k < into[group].columns.size(); ++k) {
      auto& column = into[group].columns[k];
      column.insert(column.end(), more[group].columns[k].begin(), more[group].columns[k].end());
    }
  }
}

/// The final residual as one free run per range (from gap to gap), with what it may depend on.
void append_free_run(const Part& part, const sysid::AxisModel<double>& model, ResidualInput& input) {
  const AxisData& data = part.signals.data;
  const auto settle = static_cast<std::size_t>(std::lround(kSettle_s / data.period_s));
  const auto length = static_cast<std::size_t>(std::lround(AxisBlocks::kBlock_s / data.period_s));
  std::vector<double>& residual = input.residuals[0];
  for (const Range& range : part.ranges) {
    const Range run{std::max(range.first - kSettle_s, data.start_s), range.second};
    const AxisBlocks whole(data, {run}, range.second - range.first + 2.0 * kSettle_s);
    std::vector<double> error(whole.samples());
    whole.error(model, {}, error);
    auto from = error.begin();
    for (std::size_t number = 0; number < whole.size(); ++number) {
      const std::size_t samples = whole[number].end - whole[number].begin;
      const auto to = from + static_cast<std::ptrdiff_t>(samples);
      if (samples >= settle + length) {
        const std::size_t begin = whole[number].begin + settle;
        const std::size_t end = whole[number].end;
        for (std::size_t i = begin; i < end; ++i) {
          if ((i - begin) % length == 0) {
            input.block_begin.push_back(residual.size() + i - begin);
          }
          input.time_s.push_back(data.time_s(i));
        }
        residual.insert(residual.end(), from + static_cast<std::ptrdiff_t>(settle), to);
        merge(input.groups, axis_regressors(part.log, part.signals, begin, end));
        merge(input.activity, axis_activity(part.signals, begin, end));
      }
      from = to;
    }
  }
}

/// Root mean square of the residual where the stick has rested for the model's memory: what air and autopilot leave.
double quiet_floor(const Part& part, const sysid::AxisModel<double>& model, double minimum_counts) {
  const auto rest = static_cast<std::size_t>(std::lround(1.0 / part.signals.data.period_s));
  const auto& stick = part.signals.data.stick;
  std::vector<double> error(part.blocks.samples());
  part.blocks.error(model, {}, error);
  double sum = 0.0;
  std::size_t count = 0;
  std::size_t at = 0;
  for (std::size_t block = 0; block < part.blocks.size(); ++block) {
    for (std::size_t i = part.blocks[block].begin; i < part.blocks[block].end; ++i, ++at) {
      if (i < rest || i < part.blocks[block].begin + rest / 2) {
        continue;
      }
      bool rested = true;
      for (std::size_t k = i - rest; k <= i && rested; k += 5) {
        rested = std::abs(stick[k] - stick[i]) < 3.0 * minimum_counts;
      }
      if (rested) {
        sum += error[at] * error[at];
        ++count;
      }
    }
  }
  return count > 2 * rest ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

class AxisIdentification {
 public:
  explicit AxisIdentification(const Request& request)
      : request_(request),
        training_(*request.log, request.axis, request.train),
        validation_(request.validation_log != nullptr ? *request.validation_log : *request.log, request.axis,
                    request.validate) {
    check_declared(request.declared);
    if (training_.blocks.size() < kLeastBlocks) {
      throw InputError(request.log->file, 0, "--train",
                       "needs at least " + std::to_string(kLeastBlocks) + " blocks of 2.5 s with data, has " +
                           std::to_string(training_.blocks.size()));
    }
    if (validation_.blocks.size() < 1) {
      throw InputError(validation_.log.file, 0, "--validate", "needs at least one block of 2.5 s with data");
    }
    check_moved(training_, "training");
    for (const std::string& name : request.declared) {
      if ((name == "cross_axis" || name == "tilt_limit") && training_.signals.data.other.empty()) {
        throw InputError(request.log->file, 0, name, "needs the other axis' stick, which the column map does not have");
      }
    }
  }

  IdentifyResult run() {
    const auto started = std::chrono::steady_clock::now();
    IdentifyResult result;
    result.axis = request_.axis;
    const AxisFamily family(training_.blocks);
    SelectionOptions options;
    options.progress = request_.progress;
    Selection selection = select(family, request_.declared, options);
    result.findings = selection.notes;
    withdraw_what_does_not_hold(family, selection, result);
    const Fit& final_fit = selection.final_model.fit;
    result.declared = model_result(family, selection.declared.fit);
    result.final_model = model_result(family, final_fit);
    result.candidates = selection.table;
    result.not_separable = selection.not_separable;
    tell("intervals by block bootstrap");
    result.final_intervals = intervals(family, final_fit);
    effects(family, selection, result);
    tell("what is left");
    leftovers(family, selection.declared.fit, final_fit, result);
    alignment(result);
    figures(family, selection, result);
    result.verdict = !result.unexplained.empty() ? "unexplained"
                     : result.effects.empty()    ? "nothing_missing"
                                                 : "explained";
    result.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return result;
  }

 private:
  void tell(const std::string& line) const {
    if (request_.progress) {
      request_.progress(line);
    }
  }

  /// An effect that makes unseen data worse is none, however well it fitted: a veto, never a choice between candidates.
  void withdraw_what_does_not_hold(const AxisFamily& family, Selection& selection, IdentifyResult& result) const {
    const std::vector<int> all(family.block_count(), 1);
    for (std::size_t at = selection.steps.size(); at-- > 0;) {
      Fit& fit = selection.final_model.fit;
      const std::string name = selection.steps[at].name;
      const Structure reduced = family.without(fit.structure, name);
      if (reduced == fit.structure) {
        continue;
      }
      const Fit plain = family.fit(reduced, all, &fit);
      if (validation_.blocks.rmse(family.model(fit)) <
          most_in_validation(selection.steps[at]) * validation_.blocks.rmse(family.model(plain))) {
        continue;
      }
      result.findings.push_back(name + " fits the training part but makes the validation part no better: withdrawn");
      std::erase_if(selection.not_separable,
                    [&](const auto& group) { return std::find(group.begin(), group.end(), name) != group.end(); });
      selection.steps.erase(selection.steps.begin() + static_cast<std::ptrdiff_t>(at));
      fit = plain;
    }
  }

  ModelResult model_result(const AxisFamily& family, const Fit& fit) const {
    ModelResult out;
    const sysid::AxisModel<double> model = family.model(fit);
    out.structure = fit.structure;
    if (std::find(fit.structure.begin(), fit.structure.end(), "dead_zone") != fit.structure.end()) {
      out.dead_zone_shape = model.dead_zone_shape == model::DeadZoneShape::kJump ? "jump" : "continuous";
    }
    const auto names = family.parameter_names(fit.structure);
    for (std::size_t k = 0; k < names.size(); ++k) {
      out.parameters.push_back({names[k].name, family.physical(fit, k)});
    }
    out.train_rmse = training_.blocks.rmse(model);
    out.validation_rmse = validation_.blocks.rmse(model);
    out.fit_percent = validation_.blocks.fit_percent(model);
    out.horizon_rmse = horizon_rmse(validation_.signals.data, validation_.ranges, model, kHorizons_s);
    return out;
  }

  std::vector<NamedInterval> intervals(const AxisFamily& family, const Fit& fit) const {
    const std::vector<Interval> raw = bootstrap(family, fit, request_.bootstrap_draws, request_.seed);
    const auto names = family.parameter_names(fit.structure);
    std::vector<NamedInterval> out;
    Fit low = fit;
    Fit high = fit;
    for (std::size_t k = 0; k < raw.size(); ++k) {
      low.parameters[k] = raw[k].low;
      high.parameters[k] = raw[k].high;
      const double a = family.physical(low, k);
      const double b = family.physical(high, k);
      out.push_back({names[k].name, {family.physical(fit, k), std::min(a, b), std::max(a, b)}});
    }
    return out;
  }

  void effects(const AxisFamily& family, const Selection& selection, IdentifyResult& result) const {
    const Fit& final_fit = selection.final_model.fit;
    const auto names = family.parameter_names(final_fit.structure);
    Fit before = selection.declared.fit;
    for (std::size_t at = 0; at < selection.steps.size(); ++at) {
      const Step& step = selection.steps[at];
      EffectResult effect;
      effect.name = step.name;
      effect.cv_gain = step.cv_gain;
      effect.delta_bic = step.delta_bic;
      effect.paired_t = step.paired_t;
      for (std::size_t k = 0; k < names.size(); ++k) {
        if (names[k].effect == step.name && names[k].name != "gain") {
          effect.parameters.push_back(result.final_intervals[k]);
        }
      }
      if (step.name == "dead_zone") {
        effect.shape = result.final_model.dead_zone_shape;
      }
      Structure nested = final_fit.structure;
      for (std::size_t later = at + 1; later < selection.steps.size(); ++later) {
        nested = family.without(nested, selection.steps[later].name);
      }
      const std::vector<int> all(family.block_count(), 1);
      before = nested == final_fit.structure ? final_fit : family.fit(nested, all, &before);
      effect.validation_rmse_after = validation_.blocks.rmse(family.model(before));
      for (const Step::Runner& rival : step.rivals) {
        effect.rivals.push_back({rival.name, validation_.blocks.rmse(family.model(rival.fit)), rival.cv_ratio});
      }
      result.effects.push_back(std::move(effect));
    }
  }

  /// What makes any name a guess, or the log unfit, though no regression finds it.
  void doubts(const AxisFamily& family, const Fit& declared, const Fit& fit, IdentifyResult& result) const {
    const AxisSignals& signals = training_.signals;
    const double fit_percent = training_.blocks.fit_percent(family.model(fit));
    const double share = 1.0 - fit.sum_of_squares / declared.sum_of_squares;
    const double rmse = training_.blocks.rmse(family.model(fit));
    const bool at_floor = request_.noise_floor > 0.0 && rmse < ResidualOptions{}.floor_factor * request_.noise_floor;
    if (fit_percent < kHardlyFollows && !at_floor) {
      result.unexplained.push_back("most of " + signals.response_name + ": it hardly follows " + signals.stick_name +
                                   " (fit " + std::to_string(std::lround(fit_percent)) + " %)");
    } else if (!result.effects.empty() && share < kLittle && fit_percent < kPoorFit && !at_floor) {
      result.unexplained.push_back("most of the error: what was named takes " +
                                   std::to_string(std::lround(100.0 * share)) + " % of it, the fit is " +
                                   std::to_string(std::lround(fit_percent)) + " %");
    }
    const double cut = cut_share(signals.data.stick, signals.data.valid);
    if (cut > kCutShare && fit_percent < kPoorFit && !at_floor) {
      result.unexplained.push_back(signals.stick_name + " beyond its largest value, where it stands for " +
                                   std::to_string(std::lround(100.0 * cut)) + " % of the time: was the log cut there?");
    }
    const double held_s = hold_s(signals.data.measured, signals.data.valid, signals.data.period_s);
    if (held_s > kHeld_s) {
      char text[120];
      std::snprintf(text, sizeof text, "%s holds every value for %.2f s: sampled more slowly than the log, or rounded",
                    signals.response_name.c_str(), held_s);
      result.unexplained.emplace_back(text);
    }
    const double gain = family.model(fit).gain;
    if (fit_percent > kHardlyFollows && (request_.axis == "yaw_rate" ? gain > 0.0 : gain < 0.0)) {
      result.findings.push_back(signals.response_name + " goes against " + signals.stick_name +
                                ": a sign of the column map is probably wrong");
    }
    precedence(family, fit, result);
  }

  /// A response that begins before its stick moves: the clocks of the log disagree. Only where the fit wants no delay.
  void precedence(const AxisFamily& family, const Fit& fit, IdentifyResult& result) const {
    if (family.model(fit).delay_s > 0.5 * training_.signals.data.period_s) {
      return;
    }
    AxisData early = training_.signals.data;
    const std::vector<double> stick = early.stick;
    const std::vector<int> all(family.block_count(), 1);
    double best = (1.0 - kPrecedenceGain) * fit.sum_of_squares;
    std::size_t best_shift = 0;
    for (const std::size_t shift : {2U, 4U, 6U, 8U, 12U, 16U, 20U}) {
      std::copy(stick.begin() + static_cast<std::ptrdiff_t>(shift), stick.end(), early.stick.begin());
      const AxisBlocks blocks(early, training_.ranges);
      const double sum = AxisFamily(blocks).fit(fit.structure, all, &fit).sum_of_squares;
      if (sum < best) {
        best = sum;
        best_shift = shift;
      }
    }
    if (best_shift > 0) {
      char text[120];
      std::snprintf(text, sizeof text, "the response begins before %s moves, by about %.2f s: the clocks disagree",
                    training_.signals.stick_name.c_str(), static_cast<double>(best_shift) * early.period_s);
      result.unexplained.emplace_back(text);
    }
  }

  void leftovers(const AxisFamily& family, const Fit& declared, const Fit& fit, IdentifyResult& result) const {
    const sysid::AxisModel<double> model = family.model(fit);
    ResidualInput input;
    input.sample_period_s = training_.signals.data.period_s;
    input.residuals.resize(1);
    input.noise_floor = request_.noise_floor;
    append_free_run(training_, model, input);
    append_free_run(validation_, model, input);
    const ResidualFinding finding = test_residual(input, ResidualOptions{});
    result.unexplained = finding.unexplained;
    doubts(family, declared, fit, result);
    result.noise_floor = request_.noise_floor;
    if (!(request_.noise_floor > 0.0)) {
      result.noise_floor = quiet_floor(training_, model, family.scale().minimum_counts);
      if (result.noise_floor > 0.0) {
        result.findings.emplace_back("noise floor estimated where the stick had rested for 1 s");
      }
    }
  }

  void alignment(IdentifyResult& result) const {
    const logs::Alignment& found = request_.log->alignment;
    result.alignment = {static_cast<double>(found.stick_shift_samples), found.evidence};
    for (const Part* part : {&training_, &validation_}) {
      if (part == &training_ || &validation_.log != &training_.log) {
        result.findings.insert(result.findings.end(), part->signals.findings.begin(), part->signals.findings.end());
      }
    }
    for (const std::string& note : request_.log->notes) {
      result.findings.push_back(note);
    }
    if (found.stick_shift_samples != 0) {
      result.findings.push_back("the sticks were " + std::to_string(std::abs(found.stick_shift_samples)) + " samples " +
                                (found.stick_shift_samples > 0 ? "early" : "late") + " against the response, by " +
                                found.evidence + "; moved");
    }
  }

  void figures(const AxisFamily& family, const Selection& selection, IdentifyResult& result) const {
    Figures& out = result.figures;
    out.series = {{"measured", {}}, {"declared", {}}, {"final", {}}, {"declared_residual", {}}, {"final_residual", {}}};
    for (const Part* part : {&training_, &validation_}) {
      const std::vector<double> declared = part->blocks.response(family.model(selection.declared.fit));
      const std::vector<double> final_response = part->blocks.response(family.model(selection.final_model.fit));
      std::size_t at = 0;
      for (std::size_t block = 0; block < part->blocks.size(); ++block) {
        for (std::size_t i = part->blocks[block].begin; i < part->blocks[block].end; ++i, ++at) {
          const double measured = part->signals.data.measured[i];
          out.t_s.push_back(part->signals.data.time_s(i));
          out.validation.push_back(part == &validation_ ? 1 : 0);
          out.series[0].values.push_back(measured);
          out.series[1].values.push_back(declared[at]);
          out.series[2].values.push_back(final_response[at]);
          out.series[3].values.push_back(measured - declared[at]);
          out.series[4].values.push_back(measured - final_response[at]);
        }
      }
    }
    const auto lags = static_cast<std::size_t>(std::lround(2.0 / training_.signals.data.period_s));
    for (std::size_t lag = 0; lag <= lags; lag += 2) {
      out.lag_s.push_back(static_cast<double>(lag) * training_.signals.data.period_s);
      out.declared_autocorrelation.push_back(autocorrelation(out.series[3].values, lag));
      out.final_autocorrelation.push_back(autocorrelation(out.series[4].values, lag));
    }
  }

  static double autocorrelation(const std::vector<double>& values, std::size_t lag) {
    double product = 0.0;
    double power = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      power += values[i] * values[i];
      product += i >= lag ? values[i] * values[i - lag] : 0.0;
    }
    return power > 0.0 ? product / power : 0.0;
  }

  const Request& request_;
  Part training_;
  Part validation_;
};

}  // namespace

IdentifyResult identify_axis(const Request& request) { return AxisIdentification(request).run(); }

}  // namespace m100::tools::identify
