// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/translation_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "host_tests/lab/identify/residual_tests/translation/translation_change_point.h"
#include "host_tests/lab/identify/residual_tests/translation/translation_residual.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify::translation {
namespace {

using model::TranslationEffect;

constexpr double kWeakShare = 0.25;  // of the squared error; effects that remove less may be side effects
constexpr std::array<std::string_view, 1> kBases{"rigid_body"};

bool is_periodic_force(const std::string& name) {
  const TranslationEffect* effect = model::translation_effect(name);
  return effect != nullptr && effect->is_periodic;
}

std::string words_of(ThrustSource thrust) {
  return thrust == ThrustSource::kVertical ? "the measured vertical acceleration"
         : thrust == ThrustSource::kWeight ? "weight over the cosine of the tilt"
                                           : "g times the tangents of roll and pitch";
}

}  // namespace

TranslationProblem::TranslationProblem(const Request& request, bool own_winds)
    : request_(request),
      thrust_(thrust_source(request)),
      training_(*request.log, request.train, thrust_, {own_winds, request.wind_from_first_s}),
      validation_(request.validation_log != nullptr ? *request.validation_log : *request.log, request.validate, thrust_,
                  {own_winds && in_one_log(request), request.wind_from_first_s}),
      family_(training_.blocks) {
  check_declared(request.declared, kBases, TranslationFamily::supports, "translation");
  for (const std::string& name : request.declared) {
    if (request.wind_from_first_s > 0.0 && name == "steady_wind") {
      throw InputError("--declare", 0, name,
                       "must not be declared: --wind-from-first estimates it at the start of each flight");
    }
    if (!family_.is_observable(name)) {
      throw InputError(request.log->file, 0, name, "the log has no signal in which this effect could be seen");
    }
  }
  check_heads();
  check_blocks(training_.blocks.blocks.size(), request.log->file, validation_.blocks.blocks.size(),
               validation_.log.file);
  const auto [minimum, maximum] = std::minmax_element(training_.measured.begin(), training_.measured.end());
  if (!(*maximum > *minimum)) {
    throw InputError(request.log->file, 0, training_.data.source, "is constant in the training ranges");
  }
}

double TranslationProblem::validation_rmse(const Fit& fit) const {
  return validation_.rmse(TranslationFamily::prediction(validation_.blocks, fit));
}

std::vector<std::vector<double>> TranslationProblem::validation_errors(const Fit& fit) const {
  const std::vector<double> predicted = TranslationFamily::prediction(validation_.blocks, fit);
  std::vector<std::vector<double>> out;
  for (const auto& block : validation_.blocks.blocks) {
    out.emplace_back();
    for (std::size_t row = block.row; row < block.row + block.samples.size() * validation_.data.axes; ++row) {
      out.back().push_back(validation_.measured[row] - predicted[row]);
    }
  }
  return out;
}

ModelResult TranslationProblem::errors_of(const Fit& fit) const {
  ModelResult out;
  out.train_rmse = training_.rmse(TranslationFamily::prediction(training_.blocks, fit));
  const std::vector<double> predicted = TranslationFamily::prediction(validation_.blocks, fit);
  out.validation_rmse = validation_.rmse(predicted);
  out.fit_percent = validation_.fit_percent(predicted);
  out.horizon_rmse = validation_.horizon_rmse(predicted);
  return out;
}

std::vector<Problem::Parameter> TranslationProblem::parameters(const Fit& fit) const {
  std::vector<Parameter> out;
  for (const std::string& name : fit.structure) {
    for (const NamedValue& value : TranslationFamily::parameters(fit, name)) {
      out.push_back({name, value});
    }
  }
  return out;
}

std::vector<double> TranslationProblem::coordinates(const Fit& fit) const {
  std::vector<double> out;
  for (const Parameter& parameter : parameters(fit)) {
    out.push_back(parameter.value.value);
  }
  return out;
}

double TranslationProblem::reported(const Fit& fit, std::size_t parameter, double coordinate) const {
  std::size_t first = 0;
  for (const std::string& name : fit.structure) {
    const TranslationEffect* effect = model::translation_effect(name);
    const std::size_t count = TranslationFamily::parameters(fit, name).size();
    if (effect != nullptr && parameter < first + count && parameter - first < effect->parameter_count()) {
      const model::EffectParameter& range = effect->parameters[parameter - first];
      const double value = TranslationFamily::parameters(fit, name)[parameter - first].value;
      return range.low < range.high && value >= range.low && value <= range.high
                 ? std::clamp(coordinate, range.low, range.high)
                 : coordinate;
    }
    first += count;
  }
  return coordinate;
}

std::vector<Finding> TranslationProblem::tether(const Fit& fit) const { return position_force(training_, fit); }

std::vector<Change> TranslationProblem::changes(const Fit& fit) const {
  return change_points(training_, &validation_.log == &training_.log ? &validation_ : nullptr, fit);
}

void TranslationProblem::examine(const Selection& selection, IdentifyResult& result) const {
  result.unexplained = residual_findings(request_, training_, validation_, selection.final_model.fit);
}

bool TranslationProblem::are_side_effects(const Selection& selection, const IdentifyResult& result) const {
  return weak(selection) || still_oscillates(selection.steps, result);
}

void TranslationProblem::annotate(const Selection& selection, IdentifyResult& result) const {
  add_indistinguishable(selection.steps, result);
  if (request_.wind_from_first_s > 0.0) {
    for (const TranslationDataSet* part : {&training_, &validation_}) {
      result.findings.push_back(
          note(std::string(part == &training_ ? "training: " : "validation: ") +
               describe_head_winds(*part, selection.final_model.fit, request_.wind_from_first_s)));
    }
  }
  result.findings.push_back(
      note("acceleration from " + training_.data.source + ", filtered over 0.2 s like the prediction"));
  if (!training_.data.has_thrust) {
    result.findings.push_back(note("no thrust set point in the log: thrust is taken as " + words_of(thrust_) +
                                   ", which fits these data best; only the horizontal axes are tested"));
  }
  add_motion_note(result);
}

void TranslationProblem::add_motion_note(IdentifyResult& result) {
  for (const CandidateRow& row : result.candidates) {
    const bool refused = is_periodic_force(row.name) && !row.accepted && !row.is_significant && row.cv_gain > 0.25;
    if (refused && row.round == result.candidates.back().round) {
      result.findings.push_back(
          note("a periodic force would fit, but the vehicle itself moves with this period, so it is not named"));
    }
  }
}

Traces TranslationProblem::traces(const Fit& declared, const Fit& final_fit) const {
  static const std::array<const char*, 3> kAxes{"_x", "_y", "_z"};
  Traces out;
  out.sample_period_s = training_.blocks.sample_period_s;
  out.longest_lag_s = 3.0;
  out.about_mean = true;
  for (std::size_t c = 0; c < training_.data.axes; ++c) {
    out.directions.push_back({kAxes[c], {}, {}, {}, {}});
  }
  for (const TranslationDataSet* part : {&training_, &validation_}) {
    for (const auto& block : part->blocks.blocks) {
      for (const std::size_t i : block.samples) {
        out.t_s.push_back(part->data.time_s(i));
        out.validation.push_back(part == &validation_ ? 1 : 0);
      }
    }
    Fit rigid{.structure = {"rigid_body"}, .parameters = std::vector<double>(kSearched, 0.0), .shape = {}};
    const std::vector<double> tilted = TranslationFamily::prediction(part->blocks, rigid);
    const std::vector<double> as_declared = TranslationFamily::prediction(part->blocks, declared);
    const std::vector<double> as_found = TranslationFamily::prediction(part->blocks, final_fit);
    for (std::size_t c = 0; c < out.directions.size(); ++c) {
      const auto append = [&](std::vector<double>& to, const std::vector<double>& rows) {
        const std::vector<double> axis = part->axis(rows, c);
        to.insert(to.end(), axis.begin(), axis.end());
      };
      append(out.directions[c].input, tilted);
      append(out.directions[c].measured, part->measured);
      append(out.directions[c].declared, as_declared);
      append(out.directions[c].final_model, as_found);
    }
  }
  return out;
}

void TranslationProblem::check_heads() const {
  for (const TranslationDataSet* part : {&training_, &validation_}) {
    const std::size_t flight = part->blocks.head == nullptr ? 0 : flight_without_head(part->blocks);
    if (flight > 0) {
      throw InputError(part->log.file, 0, "--wind-from-first",
                       "log " + std::to_string(flight) + " has no usable 2.5 s block in its first seconds");
    }
  }
}

bool TranslationProblem::weak(const Selection& selection) {
  return selection.final_model.fit.sum_of_squares > (1.0 - kWeakShare) * selection.declared.fit.sum_of_squares;
}

bool TranslationProblem::still_oscillates(const std::vector<SelectionStep>& steps, const IdentifyResult& result) {
  return std::any_of(steps.begin(), steps.end(),
                     [](const SelectionStep& step) { return is_periodic_force(step.name); }) &&
         std::any_of(result.unexplained.begin(), result.unexplained.end(), [&](const std::string& text) {
           return text.rfind("periodic", 0) == 0 || text.rfind("oscillation", 0) == 0;
         });
}

void TranslationProblem::add_indistinguishable(const std::vector<SelectionStep>& steps, IdentifyResult& result) const {
  bool wind = false;
  bool drag = false;
  for (const SelectionStep& step : steps) {
    const TranslationEffect& effect = *model::translation_effect(step.name);
    wind = wind || (effect.searched_count() > 0 && effect.searched[0].start == model::Start::kWindSpeed);
    drag = drag || effect.drag != model::Drag::kNone;
    const std::string other(effect.equivalent);
    const auto named = [&](const std::vector<std::string>& group) {
      return std::find(group.begin(), group.end(), step.name) != group.end() &&
             std::find(group.begin(), group.end(), other) != group.end();
    };
    if (other.empty()) {
      continue;
    }
    if (!training_.data.has_yaw && std::none_of(result.not_separable.begin(), result.not_separable.end(), named)) {
      result.not_separable.push_back({step.name, other});
      result.findings.push_back(
          note("without attitude_yaw a wind cannot be distinguished from a force fixed to the body"));
    }
    if (std::any_of(result.not_separable.begin(), result.not_separable.end(), named)) {
      result.not_separable.push_back({step.name, "trim_offset"});
      result.findings.push_back(note("the heading hardly changed: turn the vehicle in flight to tell wind from bias"));
    }
  }
  if (wind && drag) {
    result.findings.push_back(
        note("drag acts on the velocity relative to the air, so wind and drag are fitted together: the wind's "
             "acceleration is known, but its speed only as accurately as the drag coefficient"));
  }
}

}  // namespace m100::lab::identify::translation
