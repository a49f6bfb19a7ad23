// SPDX-License-Identifier: BSD-3-Clause
// Translation: from a log and a declared model to a verdict.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "host_tests/lab/identify/log_defects.h"
#include "host_tests/lab/identify/log_ground.h"
#include "host_tests/lab/identify/log_units.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/search/sides.h"
#include "host_tests/lab/identify/search/study.h"
#include "host_tests/lab/identify/translation/translation_change.h"
#include "host_tests/lab/identify/translation/translation_family.h"
#include "host_tests/lab/identify/translation/translation_part.h"
#include "host_tests/lab/identify/translation/translation_remainder.h"
#include "host_tests/lab/identify/translation/translation_repair.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {
namespace {

using namespace translation;  // its own parts
using model::TranslationEffect;

constexpr double kMinimumCvGain = 0.03;  // the force residual has no memory: less is needed than on a stick axis
constexpr double kWeakShare = 0.25;  // of the mean square: what must be explained before a remainder to trust a name
constexpr std::array<std::string_view, 1> kBases{"rigid_body"};
const std::vector<double> kHorizons_s{0.2, 0.5, 1.0, 2.0};

bool has_own_clock(const std::string& name) {
  const TranslationEffect* effect = model::translation_effect(name);
  return effect != nullptr && effect->own_clock;
}

class TranslationStudy final : public Study {
 public:
  explicit TranslationStudy(const Request& request)
      : request_(request),
        thrust_(thrust_source(request)),
        training_(*request.log, request.train, thrust_),
        validation_(request.validation_log != nullptr ? *request.validation_log : *request.log, request.validate,
                    thrust_),
        family_(training_.blocks) {
    check_declared(request.declared, kBases, TranslationFamily::knows, "translation");
    for (const std::string& name : request.declared) {
      if (!family_.can_see(name)) {
        throw InputError(request.log->file, 0, name, "the log has no signal that this effect would show in");
      }
    }
    check_blocks(training_.blocks.blocks.size(), request.log->file, validation_.blocks.blocks.size(),
                 validation_.log.file);
    const auto [least, most] = std::minmax_element(training_.measured.begin(), training_.measured.end());
    if (!(*most > *least)) {
      throw InputError(request.log->file, 0, training_.data.source, "is one constant in the training ranges");
    }
  }

  const Family& family() const override { return family_; }

  double validation_rmse(const Fit& fit) const override {
    return validation_.rmse(TranslationFamily::prediction(validation_.blocks, fit));
  }

  std::vector<std::vector<double>> validation_errors(const Fit& fit) const override {
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

  ModelResult errors_of(const Fit& fit) const override {
    ModelResult out;
    out.train_rmse = training_.rmse(TranslationFamily::prediction(training_.blocks, fit));
    const std::vector<double> predicted = TranslationFamily::prediction(validation_.blocks, fit);
    out.validation_rmse = validation_.rmse(predicted);
    out.fit_percent = validation_.fit_percent(predicted);
    out.horizon_rmse = validation_.horizon_rmse(predicted, kHorizons_s);
    return out;
  }

  std::vector<Parameter> parameters(const Fit& fit) const override {
    std::vector<Parameter> out;
    for (const std::string& name : fit.structure) {
      for (const NamedValue& value : TranslationFamily::parameters(fit, name)) {
        out.push_back({name, value});
      }
    }
    return out;
  }

  std::vector<double> coordinates(const Fit& fit) const override {
    std::vector<double> out;
    for (const Parameter& parameter : parameters(fit)) {
      out.push_back(parameter.value.value);
    }
    return out;
  }

  /// An interval ends where the physical range does.
  double reported(const Fit& fit, std::size_t parameter, double coordinate) const override {
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

  std::vector<Finding> tether(const Fit& fit) const { return position_force(training_, fit); }

  /// What changed in mid-flight, over both parts where they are of one log.
  std::vector<Change> changes(const Fit& fit) const {
    return changes_of(training_, &validation_.log == &training_.log ? &validation_ : nullptr, fit);
  }

  void examine(const Selection& selection, IdentifyResult& result) const override {
    result.unexplained = remainder_of(request_, training_, validation_, selection.final_model.fit);
  }

  bool shadow_only(const Selection& selection, const IdentifyResult& result) const override {
    return weak(selection) || swinging(selection.steps, result);
  }

  void annotate(const Selection& selection, IdentifyResult& result) const override {
    twins(selection.steps, result);
    const logs::Alignment& found = request_.log->alignment;
    // A correlation is that of the rates with the attitude: it says nothing of the sticks.
    result.alignment = {static_cast<double>(found.stick_shift_samples),
                        found.evidence == "sequence" ? found.evidence : "none"};
    const std::vector<Finding> ground = ground_findings(ground_times(*request_.log));
    result.findings.insert(result.findings.end(), ground.begin(), ground.end());
    for (const std::string& said : request_.log->notes) {
      result.findings.push_back(note(said));
    }
    result.findings.push_back(
        note("acceleration from " + training_.data.source + ", filtered over 0.2 s like the prediction"));
    if (!training_.data.has_thrust) {
      result.findings.push_back(note(std::string("no thrust set point in the log: thrust is taken as ") +
                                     (thrust_ == Thrust::kVertical ? "what the vertical shows"
                                      : thrust_ == Thrust::kWeight ? "weight over the cosine of the tilt"
                                                                   : "g times the tangents of roll and pitch") +
                                     ", which these data prefer; only the horizontal axes are tested"));
    }
    for (const CandidateRow& row : result.candidates) {
      const bool refused = has_own_clock(row.name) && !row.accepted && !row.big_enough && row.cv_gain > 0.25;
      if (refused && row.round == result.candidates.back().round) {
        result.findings.push_back(
            note("a periodic force would fit, but the vehicle itself moves with that period: the force is not named"));
      }
    }
  }

  Traces traces(const Fit& declared, const Fit& final_fit) const override {
    static const std::array<const char*, 3> kAxes{"_x", "_y", "_z"};
    Traces out;
    out.sample_period_s = training_.blocks.sample_period_s;
    out.longest_lag_s = 3.0;
    out.about_mean = true;
    for (std::size_t c = 0; c < training_.data.axes; ++c) {
      out.directions.push_back({kAxes[c], {}, {}, {}});
    }
    for (const Part* part : {&training_, &validation_}) {
      for (const auto& block : part->blocks.blocks) {
        for (const std::size_t i : block.samples) {
          out.t_s.push_back(part->data.time_s(i));
          out.validation.push_back(part == &validation_ ? 1 : 0);
        }
      }
      const std::vector<double> as_declared = TranslationFamily::prediction(part->blocks, declared);
      const std::vector<double> as_found = TranslationFamily::prediction(part->blocks, final_fit);
      for (std::size_t c = 0; c < out.directions.size(); ++c) {
        const auto append = [&](std::vector<double>& to, const std::vector<double>& rows) {
          const std::vector<double> axis = part->axis(rows, c);
          to.insert(to.end(), axis.begin(), axis.end());
        };
        append(out.directions[c].measured, part->measured);
        append(out.directions[c].declared, as_declared);
        append(out.directions[c].final_model, as_found);
      }
    }
    return out;
  }

 private:
  /// Little of the error is explained: with a remainder of unknown cause, so small a share may be the cause's shadow.
  static bool weak(const Selection& selection) {
    return selection.final_model.fit.sum_of_squares > (1.0 - kWeakShare) * selection.declared.fit.sum_of_squares;
  }

  /// A line was named, and yet what is left still swings: it was never a line.
  static bool swinging(const std::vector<Step>& steps, const IdentifyResult& result) {
    return std::any_of(steps.begin(), steps.end(), [](const Step& step) { return has_own_clock(step.name); }) &&
           std::any_of(result.unexplained.begin(), result.unexplained.end(), [&](const std::string& text) {
             return text.rfind("periodic", 0) == 0 || text.rfind("oscillation", 0) == 0;
           });
  }

  /// At constant heading a wind, a bias of the body and a trim of the sticks are one and the same: said by name.
  void twins(const std::vector<Step>& steps, IdentifyResult& result) const {
    bool wind = false;
    bool drag = false;
    for (const Step& step : steps) {
      const TranslationEffect& effect = *model::translation_effect(step.name);
      wind = wind || (effect.searched_count() > 0 && effect.searched[0].start == model::Start::kWindSpeed);
      drag = drag || effect.drag != model::Drag::kNone;
      const std::string other(effect.twin);
      const auto named = [&](const std::vector<std::string>& group) {
        return std::find(group.begin(), group.end(), step.name) != group.end() &&
               std::find(group.begin(), group.end(), other) != group.end();
      };
      if (other.empty()) {
        continue;
      }
      if (!training_.data.has_yaw && std::none_of(result.not_separable.begin(), result.not_separable.end(), named)) {
        result.not_separable.push_back({step.name, other});
        result.findings.push_back(note("without attitude_yaw a wind cannot be told from what turns with the body"));
      }
      if (std::any_of(result.not_separable.begin(), result.not_separable.end(), named)) {
        result.not_separable.push_back({step.name, "trim_offset"});
        result.findings.push_back(
            note("the heading hardly changed: turn the vehicle in flight to tell wind from bias"));
      }
    }
    if (wind && drag) {
      result.findings.push_back(
          note("drag acts on the velocity relative to the air, so that wind and drag are fitted together: the wind's "
               "acceleration is known, its speed only as well as the drag coefficient"));
    }
  }

  const Request& request_;
  Thrust thrust_;
  Part training_;
  Part validation_;
  TranslationFamily family_;
};

/// The order in which a log is asked: what may be wrong with it, structure, place, change, and the structure again on
/// one side of the change.
class TranslationInquiry {
 public:
  TranslationInquiry(const Request& request, Beside beside) : request_(request), beside_(std::move(beside)) {}

  /// @param misread  the log's axes or signs are wrong: whatever is fitted would be the shadow of that
  IdentifyResult run(bool misread) {
    options_.minimum_cv_gain = kMinimumCvGain;
    options_.maximum_effects = misread ? 0 : options_.maximum_effects;
    study_ = std::make_unique<TranslationStudy>(request_);
    chosen_ = choose(*study_, request_, options_);
    if (!misread) {
      const std::vector<Finding> tether = study_->tether(chosen_.final_model.fit);
      beside_.findings.insert(beside_.findings.end(), tether.begin(), tether.end());
      if (tether.empty()) {  // a force that depends on the place changes with it
        ask_for_a_change();
      }
    }
    return conclude(*study_, side_ ? *side_ : request_, std::move(chosen_), std::move(beside_));
  }

 private:
  /// A change spoils the structure, and a missing structure looks like a change: so the structure is chosen again on
  /// one side of the date, and the change must stand under it.
  void ask_for_a_change() {
    std::vector<Change> changes = study_->changes(chosen_.final_model.fit);
    if (changes.empty()) {
      return;
    }
    for (const Request& side : sides_of(request_, changes.front())) {
      std::unique_ptr<TranslationStudy> calm = study_of(side);
      if (calm == nullptr) {
        continue;
      }
      Selection chosen = choose(*calm, side, options_);
      changes = study_->changes(chosen.final_model.fit);
      if (changes.empty()) {
        return;
      }
      side_ = std::make_unique<Request>(side);
      study_ = std::make_unique<TranslationStudy>(*side_);
      chosen_ = std::move(chosen);
      beside_.findings.push_back(side_note(side));
      break;
    }
    for (const Change& change : changes) {
      take(change);
    }
  }

  /// One side of a change; null where it has too little that can be used.
  static std::unique_ptr<TranslationStudy> study_of(const Request& side) {
    try {
      return std::make_unique<TranslationStudy>(side);
    } catch (const InputError&) {
      return nullptr;
    }
  }

  /// What changed is not named among the effects, nor is what these data cannot tell from it.
  void take(const Change& change) {
    const std::string effect = change.name == "mass" ? "thrust_gain" : change.name;  // what the change looks like
    const std::string twin(model::translation_effect(effect)->twin);
    const bool alike = std::any_of(chosen_.not_separable.begin(), chosen_.not_separable.end(), [&](const auto& group) {
      return std::find(group.begin(), group.end(), effect) != group.end() &&
             std::find(group.begin(), group.end(), twin) != group.end();
    });
    const auto same = [&](const std::string& name) { return name == effect || (alike && name == twin); };
    std::erase_if(chosen_.steps, [&](const Step& step) { return same(step.name); });
    std::erase_if(chosen_.not_separable,
                  [&](const auto& group) { return std::any_of(group.begin(), group.end(), same); });
    if (!change.rivals.empty()) {
      std::string names = change.name;
      for (const std::string& rival : change.rivals) {
        names += " or " + rival;
      }
      beside_.unexplained.push_back("something that changed in mid-flight: " + names);
    }
    beside_.changes.push_back(change);
  }

  const Request& request_;
  std::unique_ptr<Request> side_;  ///< of the change, where one was found
  SelectionOptions options_;
  std::unique_ptr<TranslationStudy> study_;
  Selection chosen_;
  Beside beside_;
};

}  // namespace

IdentifyResult identify_translation(const Request& request) {
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
  return TranslationInquiry(cleaned, std::move(beside)).run(!signs.empty());
}

}  // namespace m100::lab::identify
