// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/problem.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "firmware/companion/files/text/suggestion.h"
#include "firmware/model/axis_effects.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"
#include "host_tests/lab/identify/selection/criteria.h"
#include "host_tests/lab/identify/selection/jackknife.h"
#include "host_tests/lab/identify/selection/structure_spread.h"
#include "host_tests/lab/identify/selection/verdict.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

void report_progress(const Request& request, const std::string& line) {
  if (request.progress) {
    request.progress(line);
  }
}

/// Withdraws an effect if the validation error with it is not below max_validation_ratio() times that without it.
void withdraw_unconfirmed(const Problem& problem, Selection& selection) {
  const Family& family = problem.family();
  const std::vector<int> all(family.block_count(), 1);
  for (std::size_t at = selection.steps.size(); at-- > 0;) {
    Fit& fit = selection.final_model.fit;
    const std::string name = selection.steps[at].name;
    const Structure reduced = family.without(fit.structure, name);
    if (reduced == fit.structure) {
      continue;
    }
    const Fit plain = family.fit(reduced, all, &fit);
    const bool stays = family.completed(reduced) != reduced;  // a nuisance parameter, which only loses its name
    const double plain_rmse = problem.validation_rmse(plain);
    if (problem.validation_rmse(fit) < max_validation_ratio(selection.steps[at]) * plain_rmse) {
      if (stays) {
        selection.notes.push_back(
            printed("%s is fitted in every model; at its declared value the validation error would be %.4g",
                    name.c_str(), plain_rmse));
      }
      continue;
    }
    selection.notes.push_back(name + " improves the training error but not the validation error: it was withdrawn");
    withdraw(selection, name);
    fit = stays ? fit : plain;
  }
}

class Conclusion {
 public:
  Conclusion(const Problem& problem, const Request& request, Selection selection, SideFindings side_findings)
      : problem_(problem), family_(problem.family()), request_(request), selection_(std::move(selection)) {
    result_.findings = std::move(side_findings.findings);
    result_.changes = std::move(side_findings.changes);
    result_.remainder = std::move(side_findings.remainder);
    side_unexplained_ = std::move(side_findings.unexplained);
  }

  IdentifyResult run() {
    result_.axis = request_.axis;
    result_.candidates = selection_.table;
    add_notes(selection_.notes);
    report_progress(request_, "residual tests");
    result_.noise_floor = request_.noise_floor;
    problem_.examine(selection_, result_);
    withdraw_guesses();
    result_.unexplained.insert(result_.unexplained.end(), side_unexplained_.begin(), side_unexplained_.end());
    result_.not_separable = selection_.not_separable;
    const Fit& final_fit = selection_.final_model.fit;
    result_.declared = model_result(selection_.declared.fit);
    result_.final_model = model_result(final_fit);
    report_progress(request_, "intervals (block jackknife)");
    intervals(final_fit);
    effects(final_fit);
    // An alignment by correlation used the rates and the attitude, so it is no evidence for the sticks.
    const logs::Alignment& found = request_.log->alignment;
    result_.alignment = {static_cast<double>(found.stick_shift_samples),
                         found.evidence == "sequence" ? found.evidence : "none"};
    problem_.annotate(selection_, result_);
    add_notes(request_.log->notes);
    for (const std::string& said : in_one_log(request_) ? std::vector<std::string>{} : request_.validation_log->notes) {
      result_.findings.push_back(note("validation log: " + said));
    }
    figures(problem_.traces(selection_.declared.fit, final_fit));
    const std::vector<int> all(family_.block_count(), 1);
    ValidationComparison parts =
        compared(final_fit, family_.errors(final_fit, all), problem_.validation_errors(final_fit));
    parts.across_a_change = across_a_change();
    check_completeness(parts, CompletenessLimits{}, result_);
    report_untested(final_fit);
    result_.verdict = verdict_of(result_);
    if (result_.verdict == "unexplained" && result_.unexplained.empty()) {
      for (const Finding& finding : result_.findings) {
        if (forbids_nothing_missing(finding)) {
          result_.unexplained.push_back(finding.text);
        }
      }
    }
    date_findings(request_, result_.findings);
    return std::move(result_);
  }

 private:
  /// Compares the errors of both parts twice: whole, and without what the uncertainty of the input may have caused.
  /// Takes the result with the larger probability of chance.
  ValidationComparison compared(const Fit& fit, std::vector<std::vector<double>> training,
                                std::vector<std::vector<double>> validation) const {
    const std::size_t start = problem_.start_samples();
    ValidationComparison whole = compare_validation(training, validation, fit.free_parameters, start);
    whole.are_starts_measured = problem_.are_starts_measured();
    problem_.subtract_input_uncertainty(fit, training, validation);
    ValidationComparison known = compare_validation(training, validation, fit.free_parameters, start);
    known.ratio = whole.ratio;
    known.are_starts_measured = whole.are_starts_measured;
    return known.probability > whole.probability ? known : whole;
  }

  /// Reports effects that the unseen commands do not exercise, e.g. a limit that they never reach: switched off, with
  /// all other parameters known, they change the prediction of the unseen data by less than a standard error.
  void report_untested(const Fit& fit) {
    const std::vector<std::vector<double>> with = problem_.validation_errors(fit);
    for (const SelectionStep& step : selection_.steps) {
      if (family_.without(fit.structure, step.name) == fit.structure) {
        continue;  // another effect needs it, and is tested with it
      }
      std::vector<std::vector<double>> more = problem_.validation_errors(family_.switched_off(fit, step.name));
      std::vector<std::vector<double>> less = more;
      for (std::size_t block = 0; block < with.size(); ++block) {
        std::transform(with[block].begin(), with[block].end(), more[block].begin(), less[block].begin(),
                       [](double error, double other) { return 2.0 * error - other; });
      }
      // The mean over both signs of the change does not depend on how the noise happens to agree with it.
      const double ratio = 0.5 * (whitened_criterion(more, with, 0) + whitened_criterion(less, with, 0));
      if (ratio < 1.0) {
        result_.unexplained.push_back(
            printed("%s is not tested on unseen data: without it their prediction changes by %.2g standard errors",
                    step.name.c_str(), std::sqrt(std::max(0.0, ratio))));
      }
    }
  }

  /// Whether a change lies between the first and the last time of both parts; if they are of two logs, any change does.
  bool across_a_change() const {
    double from_s = std::numeric_limits<double>::infinity();
    double to_s = -from_s;
    for (const std::vector<Range>* part : {&request_.train, &request_.validate}) {
      for (const Range& range : *part) {
        from_s = std::min(from_s, range.first);
        to_s = std::max(to_s, range.second);
      }
    }
    return std::any_of(result_.changes.begin(), result_.changes.end(), [&](const Change& change) {
      return !in_one_log(request_) || (from_s < change.at_s && change.at_s < to_s);
    });
  }

  void add_notes(const std::vector<std::string>& sentences) {
    std::transform(sentences.begin(), sentences.end(), std::back_inserter(result_.findings), note);
  }

  void withdraw_guesses() {
    if (result_.unexplained.empty() || selection_.steps.empty() || !problem_.are_side_effects(selection_, result_)) {
      return;
    }
    for (const SelectionStep& step : selection_.steps) {
      result_.findings.push_back(
          note(step.name + " would fit, but an unknown cause dominates the residual: naming it would be a guess"));
    }
    selection_.steps.clear();
    selection_.not_separable.clear();
    selection_.final_model.fit = selection_.declared.fit;
    // The names were withdrawn for an unknown cause: it stays in the result even if the second test finds nothing.
    const std::vector<std::string> cause = std::move(result_.unexplained);
    result_.unexplained.clear();
    problem_.examine(selection_, result_);
    if (result_.unexplained.empty()) {
      result_.unexplained = cause;
    }
  }

  /// A unique name of a parameter within the whole model: two gains of translation must not share a key.
  static std::string own_name(const Problem::Parameter& parameter) {
    return parameter.value.name == "gain" && !parameter.effect.empty() ? parameter.effect : parameter.value.name;
  }

  ModelResult model_result(const Fit& fit) const {
    ModelResult out = problem_.errors_of(fit);
    out.structure = fit.structure;
    for (const Problem::Parameter& parameter : problem_.parameters(fit)) {
      out.parameters.push_back({own_name(parameter), parameter.value.value});
    }
    return out;
  }

  void intervals(const Fit& fit) {
    std::vector<Interval> spread = jackknife(
        family_, fit, [&](const Fit& one) { return problem_.coordinates(one); }, request_.refits);
    if (request_.refits >= 2) {
      add_structures(fit, spread);
    }
    for (std::size_t k = 0; k < spread.size(); ++k) {
      const double a = problem_.reported(fit, k, spread[k].low);
      const double b = problem_.reported(fit, k, spread[k].high);
      const NamedValue& value = result_.final_model.parameters[k];
      result_.final_intervals.push_back({value.name, {value.value, std::min(a, b), std::max(a, b)}});
    }
  }

  /// Widens intervals of coordinates by the spread over the structures that the log does not exclude.
  void add_structures(const Fit& fit, std::vector<Interval>& spread) const {
    constexpr double kNormal95 = 1.959964;
    std::vector<Fit> alternatives = selection_.alternatives;
    for (const SelectionStep& step : selection_.steps) {
      std::transform(step.rivals.begin(), step.rivals.end(), std::back_inserter(alternatives),
                     [](const SelectionStep::RivalFit& rival) { return rival.fit; });
    }
    const std::vector<Fit> variants = family_.variants(fit);
    alternatives.insert(alternatives.end(), variants.begin(), variants.end());
    const std::vector<double> of_structure = structure_spread(problem_, fit, alternatives);
    for (std::size_t k = 0; k < spread.size(); ++k) {
      const double half_width = std::hypot(0.5 * (spread[k].high - spread[k].low), kNormal95 * of_structure[k]);
      spread[k].low = spread[k].value - half_width;
      spread[k].high = spread[k].value + half_width;
    }
  }

  void effects(const Fit& final_fit) {
    const std::vector<int> all(family_.block_count(), 1);
    const std::vector<Problem::Parameter> parameters = problem_.parameters(final_fit);
    Fit before = selection_.declared.fit;
    for (std::size_t at = 0; at < selection_.steps.size(); ++at) {
      const SelectionStep& step = selection_.steps[at];
      EffectResult effect;
      effect.name = step.name;
      effect.cv_gain = step.cv_gain;
      effect.delta_bic = step.delta_bic;
      effect.paired_t = step.paired_t;
      for (std::size_t k = 0; k < parameters.size(); ++k) {
        if (parameters[k].effect == step.name) {
          effect.parameters.push_back({parameters[k].value.name, result_.final_intervals[k].interval});
        }
      }
      Structure nested = final_fit.structure;
      for (std::size_t later = at + 1; later < selection_.steps.size(); ++later) {
        nested = family_.without(nested, selection_.steps[later].name);
      }
      before = nested == final_fit.structure ? final_fit : family_.fit(nested, all, &before);
      effect.validation_rmse_after = problem_.validation_rmse(before);
      for (const SelectionStep::RivalFit& rival : step.rivals) {
        effect.rivals.push_back({rival.name, problem_.validation_rmse(rival.fit), rival.cv_ratio});
      }
      result_.effects.push_back(std::move(effect));
    }
  }

  void figures(Traces traces) {
    Figures& out = result_.figures;
    out.t_s = std::move(traces.t_s);
    out.sample_period_s = traces.sample_period_s;
    out.validation = std::move(traces.validation);
    std::vector<double> all_declared;
    std::vector<double> all_final;
    for (Trace& trace : traces.directions) {
      const auto add = [&](const char* name, std::vector<double> values) {
        out.series.push_back({name + trace.suffix, std::move(values)});
      };
      std::vector<double> declared_residual = difference(trace.measured, trace.declared, all_declared);
      std::vector<double> final_residual = difference(trace.measured, trace.final_model, all_final);
      add("input", std::move(trace.input));
      add("measured", std::move(trace.measured));
      add("declared", std::move(trace.declared));
      add("final", std::move(trace.final_model));
      add("declared_residual", std::move(declared_residual));
      add("final_residual", std::move(final_residual));
    }
    const auto longest = static_cast<std::size_t>(std::lround(traces.longest_lag_s / traces.sample_period_s));
    for (std::size_t lag = 0; lag <= longest && lag < all_final.size(); lag += traces.lag_step) {
      out.lag_s.push_back(static_cast<double>(lag) * traces.sample_period_s);
      out.declared_autocorrelation.push_back(autocorrelation(all_declared, lag, traces.about_mean));
      out.final_autocorrelation.push_back(autocorrelation(all_final, lag, traces.about_mean));
    }
  }

  static std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b,
                                        std::vector<double>& all) {
    std::vector<double> out(a.size());
    std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::minus<>{});
    all.insert(all.end(), out.begin(), out.end());
    return out;
  }

  const Problem& problem_;
  const Family& family_;
  const Request& request_;
  Selection selection_;
  IdentifyResult result_;
  std::vector<std::string> side_unexplained_;
};

}  // namespace

Selection select_effects(const Problem& problem, const Request& request, SelectionOptions options) {
  options.progress = request.progress;
  options.start_samples = problem.start_samples();
  Selection selection = select(problem.family(), request.declared, options);
  withdraw_unconfirmed(problem, selection);
  return selection;
}

void withdraw(Selection& selection, const std::string& name) {
  std::erase_if(selection.steps, [&](const SelectionStep& step) { return step.name == name; });
  std::erase_if(selection.not_separable, [&](const auto& group) { return has(group, name); });
}

IdentifyResult conclude(const Problem& problem, const Request& request, Selection selection,
                        SideFindings side_findings) {
  return Conclusion(problem, request, std::move(selection), std::move(side_findings)).run();
}

std::string effect_meant(std::string_view word) {
  std::vector<std::string_view> known;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    known.push_back(effect.name);
  }
  for (const model::TranslationEffect& effect : model::kTranslationEffects) {
    known.push_back(effect.name);
  }
  return companion::did_you_mean(word, known);
}

void check_declared(const std::vector<std::string>& declared, std::span<const std::string_view> bases,
                    bool (*supports)(const std::string& name), const char* what) {
  const auto is_base = [&](const std::string& name) {
    return std::find(bases.begin(), bases.end(), name) != bases.end();
  };
  if (declared.empty() || !is_base(declared[0])) {
    std::string names;
    for (const std::string_view base : bases) {
      names += (names.empty() ? "" : " or ") + std::string(base);
    }
    throw InputError(
        "--declare", 0, declared.empty() ? "" : declared[0],
        "the first name must be " + names + (declared.empty() ? "" : companion::did_you_mean(declared[0], bases)));
  }
  for (std::size_t k = 1; k < declared.size(); ++k) {
    if (!supports(declared[k]) || is_base(declared[k])) {
      throw InputError("--declare", 0, declared[k],
                       std::string("not an effect of ") + what + effect_meant(declared[k]));
    }
    if (std::find(declared.begin(), declared.begin() + static_cast<std::ptrdiff_t>(k), declared[k]) !=
        declared.begin() + static_cast<std::ptrdiff_t>(k)) {
      throw InputError("--declare", 0, declared[k], "is declared twice");
    }
  }
}

void check_blocks(std::size_t training, const std::string& training_file, std::size_t validation,
                  const std::string& validation_file) {
  constexpr std::size_t kMinBlocks = 4;
  if (training < kMinBlocks) {
    throw InputError(
        training_file, 0, "--train or --split",
        "needs at least " + std::to_string(kMinBlocks) + " blocks of 2.5 s with data, has " + std::to_string(training));
  }
  if (validation < 1) {
    throw InputError(validation_file, 0, "--validate or --split", "needs at least one block of 2.5 s with data");
  }
}

}  // namespace m100::lab::identify
