// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/axis_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "firmware/core/maths.h"
#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/identify/model/axis/axis_structure.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab::identify {
namespace {

constexpr double kMinFollowing_percent = 50.0;  // fit [%]; below it the stick is not the main cause of the response
constexpr double kPoorFit = 80.0;      // fit [%]; below it, small effects and a clipped stick are reported as doubts
constexpr double kSmallShare = 0.25;   // of the squared error; named effects are small if they remove less
constexpr double kSwappedOwn = 0.3;    // two columns are swapped only if the own stick explains a smaller share
constexpr double kSwappedOther = 0.6;  // two columns are swapped only if the other stick explains a larger share
constexpr double kHeld_s = 0.045;
constexpr double kCutShare = 0.2;        // of the time at the stick's stops; above it the log may be clipped
constexpr double kMinTravelShare = 0.1;  // of the stick's travel in training; a smaller one does not test a model
constexpr double kFullStick = 660.0;     // counts
constexpr double kMaxTravel = 1.25;      // of full travel: a trimmed transmitter with extended end points
constexpr double kFastestTurn = 40.0;    // rad/s at full stick, beyond any gyro's range
constexpr double kSteepest = 1.6;        // rad at full stick: no command exceeds a right angle
constexpr std::array<std::string_view, 2> kBases{"first_order", "second_order"};

/// Difference of the largest and the smallest value inside of the blocks.
double travel(const AxisDataSet& part, const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t block = 0; block < part.blocks.size(); ++block) {
    for (std::size_t i = part.blocks[block].begin; i < part.blocks[block].end; ++i) {
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
  }
  return high > low ? high - low : 0.0;
}

void check_moved(const AxisDataSet& part, const char* option) {
  double largest = 0.0;
  for (const double value : part.signals.data.stick) {
    largest = std::max(largest, std::abs(value));
  }
  const double minimum = largest > 5.0 ? 10.0 : 0.01;
  if (part.blocks.size() > 0 && !(travel(part, part.signals.data.stick) > minimum)) {
    throw InputError(part.log.file, 0, part.signals.stick_name,
                     std::string("the stick was never moved in the ") + option + " ranges");
  }
  if (part.blocks.size() > 0 && !(travel(part, part.signals.data.measured) > 0.0)) {
    throw InputError(part.log.file, 0, part.signals.stick_name,
                     std::string("the response is constant in the ") + option + " ranges");
  }
}

/// Widens the interval of the dead zone's width to the nearest stick deflections in the log, below and above the width.
/// For a dead zone with a jump the log shows no more, but refits of it all end at one value.
void widen_to_stick_values(const AxisDataSet& part, const model::StickAxis& model, IdentifyResult& result) {
  double below = 0.0;
  double above = std::numeric_limits<double>::infinity();
  for (const Range& range : part.ranges) {
    for (double t_s = range.first; t_s <= range.second; t_s += part.signals.data.period_s) {
      const auto at =
          static_cast<std::size_t>(std::clamp((t_s - part.signals.data.start_s) / part.signals.data.period_s, 0.0,
                                              static_cast<double>(part.signals.data.stick.size()) - 1.0));
      const double distance = std::abs(part.signals.data.stick[at] - model.trim_counts);
      below = distance <= model.dead_zone_counts ? std::max(below, distance) : below;
      above = distance > model.dead_zone_counts ? std::min(above, distance) : above;
    }
  }
  const auto widen = [&](NamedInterval& one) {
    if (one.name == "width_counts") {
      one.interval.low = std::min(one.interval.low, below);
      one.interval.high = std::isfinite(above) ? std::max(one.interval.high, above) : one.interval.high;
    }
  };
  std::for_each(result.final_intervals.begin(), result.final_intervals.end(), widen);
  for (EffectResult& effect : result.effects) {
    std::for_each(effect.parameters.begin(), effect.parameters.end(), widen);
  }
}

}  // namespace

AxisProblem::AxisProblem(const Request& request, const StickClock& clock, const std::vector<double>& flight_trims)
    : request_(request),
      training_(*request.log, request.axis, request.train, requested_ranges(request, true), clock, flight_trims),
      validation_(in_one_log(request) ? AxisDataSet(training_, request.validate)
                                      : AxisDataSet(*request.validation_log, request.axis, request.validate,
                                                    requested_ranges(request, false), clock)) {
  check_and_make_family();
}

void AxisProblem::check_and_make_family() {
  check_declared(request_.declared, kBases, AxisFamily::supports, "a stick axis");
  check_blocks(training_.blocks.size(), request_.log->file, validation_.blocks.size(), validation_.log.file);
  check_moved(training_, "training");
  if (validation_.signals.stick_name != training_.signals.stick_name) {
    throw InputError(validation_.log.file, 0, validation_.signals.stick_name,
                     "is the input of the validation part, but the training part has " + training_.signals.stick_name);
  }
  for (const std::string& name : request_.declared) {
    if (model::axis_effect(name)->needs_other_stick && training_.signals.data.other.empty()) {
      throw InputError(request_.log->file, 0, name, "needs the other axis' stick, which the column map does not have");
    }
  }
  family_.emplace(training_.blocks);
}

bool AxisProblem::are_starts_measured() const {
  constexpr double kUnknown = 3.0;  // parameters of the quadratic through kStartSamples: fewer rows do not determine it
  const auto is_measured = [](const AxisData& data) {
    return kUnknown * data.row_s <= static_cast<double>(AxisBlocks::kStartSamples) * data.period_s;
  };
  return is_measured(training_.signals.data) && is_measured(validation_.signals.data);
}

std::vector<Range> AxisProblem::free_ranges() const {
  std::vector<Range> ranges = training_.ranges;
  if (&validation_.log == &training_.log) {
    ranges.insert(ranges.end(), validation_.ranges.begin(), validation_.ranges.end());
  }
  return ranges;
}

FreeRun AxisProblem::free_run(const AxisData& data) const { return {data, free_ranges()}; }

std::vector<std::vector<double>> AxisProblem::validation_errors(const Fit& fit) const {
  std::vector<double> flat(validation_.blocks.samples());
  validation_.blocks.error(family_->model(fit), {}, flat);
  std::vector<std::vector<double>> out;
  auto at = flat.begin();
  for (std::size_t block = 0; block < validation_.blocks.size(); ++block) {
    const auto length = static_cast<std::ptrdiff_t>(validation_.blocks[block].end - validation_.blocks[block].begin);
    out.emplace_back(at, at + length);
    at += length;
  }
  return out;
}

void AxisProblem::subtract_input_uncertainty(const Fit& fit, std::vector<std::vector<double>>& training,
                                             std::vector<std::vector<double>>& validation) const {
  const model::StickAxis model = family_->model(fit);
  for (const auto& [part, errors] : {std::pair{&training_, &training}, std::pair{&validation_, &validation}}) {
    const std::vector<double> input_uncertainty = intersample_error(part->signals.data, part->ranges, model);
    std::size_t at = 0;
    for (std::vector<double>& block : *errors) {
      for (double& error : block) {
        error = at < input_uncertainty.size()
                    ? std::copysign(std::max(0.0, std::abs(error) - input_uncertainty[at]), error)
                    : error;
        ++at;
      }
    }
  }
}

ModelResult AxisProblem::errors_of(const Fit& fit) const {
  ModelResult out;
  const model::StickAxis model = family_->model(fit);
  if (std::find(fit.structure.begin(), fit.structure.end(), "dead_zone") != fit.structure.end()) {
    out.dead_zone_shape = model.dead_zone_shape == model::DeadZoneShape::kJump ? "jump" : "continuous";
  }
  out.train_rmse = training_.blocks.rmse(model);
  out.validation_rmse = validation_.blocks.rmse(model);
  out.fit_percent = validation_.blocks.fit_percent(model);
  out.horizon_rmse = horizon_rmse(validation_.signals.data, validation_.ranges, model);
  return out;
}

std::vector<Problem::Parameter> AxisProblem::parameters(const Fit& fit) const {
  std::vector<Parameter> out;
  for (const AxisFamily::ParameterName& name : family_->parameter_names(fit.structure)) {
    const std::string effect = name.name == "gain" ? "" : name.effect;  // the gain belongs to the base model
    out.push_back({effect, {name.name, family_->physical(fit, out.size())}});
  }
  return out;
}

double AxisProblem::reported(const Fit& fit, std::size_t parameter, double coordinate) const {
  const model::AxisNumber& number = *parameters_of(fit.structure)[parameter].number;
  Fit moved = fit;  // an interval ends at the physical range
  moved.parameters[parameter] =
      std::clamp(coordinate, to_fitted(number, number.fit.low), to_fitted(number, number.fit.high));
  return family_->physical(moved, parameter);
}

void AxisProblem::examine(const Selection& selection, IdentifyResult& result) const {
  const Fit& fit = selection.final_model.fit;
  training_.blocks.release_buffers();
  validation_.blocks.release_buffers();
  // With a fit to both parts, what is left over does not depend on which part trained.
  const model::StickAxis of_both =
      in_one_log(request_) ? fitted_to(training_, free_ranges(), *family_, fit) : family_->model(fit);
  result.unexplained = residual_findings(request_, training_, validation_, of_both);
  add_doubts(selection, result);
  undersampled(family_->model(fit), result);
  if (!(request_.noise_floor > 0.0)) {
    result.noise_floor = noise_floor_at_rest(training_, family_->model(fit), family_->scale().minimum_counts);
    if (result.noise_floor > 0.0) {
      result.findings.push_back(note("the noise floor was estimated where the stick had rested for 1 s"));
    }
  }
}

void AxisProblem::annotate(const Selection& selection, IdentifyResult& result) const {
  if (result.final_model.dead_zone_shape == "jump") {
    widen_to_stick_values(training_, family_->model(selection.final_model.fit), result);
  }
  for (EffectResult& effect : result.effects) {
    effect.shape = effect.name == "dead_zone" ? result.final_model.dead_zone_shape : "";
  }
  if (training_.signals.stick_name.starts_with("command_")) {
    result.stick_unit = request_.axis == "climb" ? "m_s" : request_.axis == "yaw_rate" ? "rad_s" : "rad";
  }
  const auto add_findings_of = [&result](const AxisSignals& signals) {
    result.findings.insert(result.findings.end(), signals.findings.begin(), signals.findings.end());
  };
  add_findings_of(training_.signals);
  if (&validation_.log != &training_.log) {
    add_findings_of(validation_.signals);
  }
  if (const logs::Alignment& found = request_.log->alignment; found.stick_shift_samples != 0) {
    result.findings.push_back(note("the sticks were logged " + std::to_string(std::abs(found.stick_shift_samples)) +
                                   " samples too " + (found.stick_shift_samples > 0 ? "early" : "late") +
                                   " relative to the response (evidence: their " + found.evidence +
                                   "); the shift was removed"));
  }
}

Traces AxisProblem::traces(const Fit& declared, const Fit& final_fit) const {
  Traces out;
  out.sample_period_s = training_.signals.data.period_s;
  out.lag_step = 2;
  out.directions.push_back({"", {}, {}, {}, {}});
  Trace& trace = out.directions.front();
  for (const AxisDataSet* part : {&training_, &validation_}) {
    for (std::size_t block = 0; block < part->blocks.size(); ++block) {
      for (std::size_t i = part->blocks[block].begin; i < part->blocks[block].end; ++i) {
        out.t_s.push_back(part->signals.data.time_s(i));
        out.validation.push_back(part == &validation_ ? 1 : 0);
        trace.input.push_back(part->signals.data.stick[i]);
        trace.measured.push_back(part->signals.data.measured[i]);
      }
    }
    const std::vector<double> as_declared = part->blocks.response(family_->model(declared));
    const std::vector<double> as_found = part->blocks.response(family_->model(final_fit));
    trace.declared.insert(trace.declared.end(), as_declared.begin(), as_declared.end());
    trace.final_model.insert(trace.final_model.end(), as_found.begin(), as_found.end());
  }
  return out;
}

void AxisProblem::add_doubts(const Selection& selection, IdentifyResult& result) const {
  const Fit& fit = selection.final_model.fit;
  const model::StickAxis model = family_->model(fit);
  const AxisSignals& signals = training_.signals;
  const double fit_percent = training_.blocks.fit_percent(model);
  const double share = 1.0 - fit.sum_of_squares / selection.declared.fit.sum_of_squares;
  const double rmse = training_.blocks.rmse(model);
  const bool at_floor = request_.noise_floor > 0.0 && rmse < ResidualOptions{}.floor_factor * request_.noise_floor;
  if (fit_percent < kMinFollowing_percent && !at_floor) {
    result.unexplained.push_back(signals.response_name + " hardly follows " + signals.stick_name + " (fit " +
                                 std::to_string(std::lround(fit_percent)) +
                                 " %): most of its motion has another cause");
  } else if (!selection.steps.empty() && share < kSmallShare && fit_percent < kPoorFit && !at_floor) {
    result.unexplained.push_back("the named effects remove " + std::to_string(std::lround(100.0 * share)) +
                                 " % of the error; most of it is still unexplained (fit " +
                                 std::to_string(std::lround(fit_percent)) + " %)");
  }
  for (const std::size_t at : family_->parameters_at_bound(fit)) {
    const auto [effect, name] = family_->parameter_names(fit.structure)[at];
    result.unexplained.push_back(name + " of " + effect + " ends at the edge of its range: its true value is unknown");
  }
  if (travel(validation_, validation_.signals.data.stick) <
      kMinTravelShare * travel(training_, training_.signals.data.stick)) {
    result.unexplained.push_back(signals.stick_name + " hardly moves in the validation part: it tests nothing");
  }
  const double reach = large(signals.data.stick);
  if (signals.stick_name.starts_with("stick_") && reach > kMaxTravel * kFullStick) {
    result.findings.push_back({.what = "wrong_unit",
                               .signal = signals.stick_name,
                               .text = signals.stick_name + " reaches " + std::to_string(std::lround(reach)) +
                                       " counts from neutral, but a stick travels " +
                                       std::to_string(std::lround(kFullStick)) +
                                       ": its scale or its offset (raw neutral 1024) in the column map is wrong"});
  }
  const double cut = clipped_share(
      signals.data.stick, signals.data.valid,
      {signals.data.start_s, signals.data.period_s, std::max(signals.data.period_s, signals.data.stick_row_s)});
  if (cut > kCutShare && fit_percent < kPoorFit && !at_floor) {
    result.unexplained.push_back(signals.stick_name + " stands at its largest value for " +
                                 std::to_string(std::lround(100.0 * cut)) +
                                 " % of the time: the log may have clipped it there");
  }
  const double held_s = hold_s(signals.data.measured, signals.data.valid, signals.data.period_s);
  if (held_s > kHeld_s) {
    result.unexplained.push_back(
        printed("%s holds every value for %.2f s: sampled more slowly than the log, or rounded",
                signals.response_name.c_str(), held_s));
  }
  if (!signals.data.other.empty() && follows_other_stick()) {
    result.findings.push_back({.what = "swapped_axes",
                               .signal = signals.stick_name,
                               .text = signals.response_name + " follows " + signals.other_name + " and not " +
                                       signals.stick_name + ": two columns are probably swapped"});
  }
  if (fit_percent > kMinFollowing_percent) {
    misreadings(model, result);
  }
}

void AxisProblem::undersampled(const model::StickAxis& model, IdentifyResult& result) const {
  constexpr double kShows = 0.3;  // of the residual's root mean square: a tenth of its power
  const AxisData& data = training_.signals.data;
  const auto row = static_cast<std::size_t>(std::lround(data.stick_row_s / data.period_s));
  if (row < 2) {
    return;
  }
  // Between two rows the stick may have moved along a line or jumped: the responses to both are compared.
  AxisData jumping = data;
  for (std::size_t i = 0; i < data.stick.size(); ++i) {
    jumping.stick[i] = data.stick[std::min(i / row * row + row / 2, data.stick.size() - 1)];
  }
  const AxisBlocks blocks(jumping, training_.ranges);
  const std::vector<double> line = training_.blocks.response(model);
  const std::vector<double> jump = blocks.response(model);
  double square = 0.0;
  for (std::size_t i = 0; i < std::min(line.size(), jump.size()); ++i) {
    square += (line[i] - jump[i]) * (line[i] - jump[i]) / static_cast<double>(line.size());
  }
  const double rmse = training_.blocks.rmse(model);
  if (std::sqrt(square) < kShows * rmse) {
    return;
  }
  result.findings.push_back(note(
      printed("%s is undersampled: it moves between its rows, which are %.3f s apart; this may cause %.0f %% of the "
              "residual power and makes every delay uncertain by half a row",
              training_.signals.stick_name.c_str(), data.stick_row_s,
              100.0 * std::min(1.0, square / std::max(1e-300, rmse * rmse)))));
}

bool AxisProblem::follows_other_stick() const {
  const AxisData& data = training_.signals.data;
  return share_explained(data.stick, data.measured, data.valid, data.period_s) < kSwappedOwn &&
         share_explained(data.other, data.measured, data.valid, data.period_s) > kSwappedOther;
}

void AxisProblem::misreadings(const model::StickAxis& model, IdentifyResult& result) const {
  const AxisSignals& signals = training_.signals;
  const double gain = model.scale_per_count;
  // The yaw stick counts positive to the right and the yaw rate to the left, so this gain must be negative. All other
  // gains must be positive. A gain that changes its sign in flight is reported as a change only.
  const bool turns_round = std::any_of(result.changes.begin(), result.changes.end(), [](const Change& change) {
    return change.name == "gain" && change.parameters.front().value * change.parameters.back().value < 0.0;
  });
  if (!turns_round && (signals.stick_name == "stick_yaw" ? gain > 0.0 : gain < 0.0)) {
    result.findings.push_back({.what = "sign_reversed",
                               .signal = signals.stick_name,
                               .text = signals.response_name + " moves against " + signals.stick_name +
                                       ": a sign of the column map is probably wrong"});
  }
  if (signals.stick_name.rfind("command_", 0) == 0) {
    if (std::abs(gain) > 0.7 * core::kRadian_deg || std::abs(gain) < 1.4 / core::kRadian_deg) {
      result.findings.push_back({.what = "wrong_unit",
                                 .signal = signals.stick_name,
                                 .text = signals.response_name + " and " + signals.stick_name +
                                         " differ by a factor of " + std::to_string(std::abs(gain)) +
                                         ": one of them is probably in degrees"});
    }
    return;
  }
  constexpr double kCounts = 5.0;  // a stick that never exceeds this is logged as a fraction of its travel
  // The response at full stick is extrapolated from the response to a large stick of this log. The gain is not used,
  // because with a dead zone it is uncertain if only large sticks were flown.
  const double large = family_->scale().stick;
  const model::StickLaw<double> law(model, signals.data.period_s);
  const double per_count = 0.5 *
                           std::abs(law.limited(law.shaped(model.trim_counts + large)) -
                                    law.limited(law.shaped(model.trim_counts - large))) /
                           large;
  const double full = per_count * (large > kCounts ? kFullStick : 1.0);
  const bool turns = request_.axis == "yaw_rate";
  if (request_.axis != "climb" && full > (turns ? kFastestTurn : kSteepest)) {
    result.findings.push_back({.what = "wrong_unit",
                               .signal = signals.response_name,
                               .text = signals.response_name + " would reach " + std::to_string(full) +
                                       (turns ? " rad/s" : " rad") + " at full stick: it is probably in degrees"});
  }
}

}  // namespace m100::lab::identify
