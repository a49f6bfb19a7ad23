// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/report.h"

#include <algorithm>
#include <cmath>

#include "firmware/model/axis_effects.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/identify/output/report_figures.h"
#include "host_tests/lab/identify/output/series_csv.h"
#include "host_tests/lab/plot/charts.h"

namespace m100::lab::identify {
namespace {

using plot::joined;
using plot::number;

constexpr double kGap_s = 0.1;  ///< a longer step between samples is a gap of the log, or one between its ranges

std::string unit_of(const std::string& axis) {
  if (axis == "translation") {
    return "m/s²";
  }
  return axis == "climb" ? "m/s" : (axis == "yaw_rate" ? "rad/s" : "rad");
}

/// What get() makes of the effect's row in the tables of effects; empty where there is none.
template <typename Get>
std::string of_effect(const std::string& name, Get get) {
  if (const model::AxisEffect* const row = model::axis_effect(name)) {
    return std::string(get(*row));
  }
  const model::TranslationEffect* const row = model::translation_effect(name);
  return row == nullptr ? "" : std::string(get(*row));
}

/// The stretches of validation samples, for the shading.
std::vector<plot::Span> validation_spans(const Figures& figures) {
  std::vector<plot::Span> spans;
  for (std::size_t i = 0; i < figures.t_s.size() && i < figures.validation.size(); ++i) {
    if (figures.validation[i] == 0) {
      continue;
    }
    const bool starts =
        spans.empty() || figures.validation[i - 1] == 0 || std::abs(figures.t_s[i] - spans.back().to) > 0.5;
    if (starts) {
      spans.push_back({.from = figures.t_s[i], .to = figures.t_s[i], .label = "validation"});
    }
    spans.back().to = figures.t_s[i];
  }
  return spans;
}

std::string described(const EffectResult& effect) {
  std::vector<std::string> numbers;
  for (const NamedInterval& p : effect.parameters) {
    numbers.push_back(p.name + " " + number(p.interval.value));
  }
  return effect.name + (numbers.empty() ? "" : " (" + joined(numbers, ", ") + ")");
}

std::string missing(const IdentifyResult& r) {
  std::vector<std::string> parts;
  for (const EffectResult& effect : r.effects) {
    parts.push_back(described(effect));
  }
  for (const Change& change : r.changes) {
    parts.push_back("a change of " + change.name + " at " + number(change.at_s) + " s");
  }
  std::vector<std::string> wrong;
  for (const Refitted& one : r.refitted) {
    if (one.matters) {
      wrong.push_back(one.parameter + " " + number(one.believed) + " → " + number(one.found.value));
    }
  }
  const char* const joint = parts.empty() ? "; but numbers are wrong: " : "; wrong numbers: ";
  const char* const none =
      r.verdict == "unexplained" ? "an effect that could not be named" : "no effect that these data show";
  return (parts.empty() ? none : joined(parts, ", ")) + (wrong.empty() ? "" : joint + joined(wrong, ", ")) + ".";
}

std::string explained(const IdentifyResult& r) {
  const double before = r.declared.validation_rmse;
  const double after = r.final_model.validation_rmse;
  const std::string unit = " " + unit_of(r.axis);
  if (number(before) == number(after)) {
    return "no more than the declared model, fitted to this log: the error on data that no fit has seen is " +
           number(after) + unit + ".";
  }
  return std::string("the error on data that no fit has seen ") + (after < before ? "falls" : "rises") + " from " +
         number(before) + " to " + number(after) + unit +
         (before > 0.0 ? " (" + plot::percent(after / before - 1.0) + ")" : "") + ".";
}

/// Whether a channel predicts more of what the model leaves than chance reaches.
bool has_pattern(const IdentifyResult& r) {
  return !r.remainder.empty() && r.remainder.front().predicted > r.remainder.front().chance;
}

std::string remains(const IdentifyResult& r) {
  const std::string floor =
      r.noise_floor > 0 ? " The noise floor is " + number(r.noise_floor) + " " + unit_of(r.axis) + "." : "";
  const std::string pattern = has_pattern(r)
                                  ? " Of the remainder, " + described(r.remainder.front()) + " would predict " +
                                        number(100.0 * r.remainder.front().predicted) + " % on unseen data."
                                  : "";
  return (r.verdict == "unexplained"
              ? "unexplained: " + (r.unexplained.empty() ? std::string("the residual") : joined(r.unexplained, "; "))
              : number(r.final_model.validation_rmse) + " " + unit_of(r.axis) +
                    ", in which no known effect was found") +
         "." + floor + pattern;
}

/// Errors of the declared and of the final model, and the final validation error over the training error.
void errors_table(plot::Page& page, const IdentifyResult& r) {
  const std::string unit = unit_of(r.axis);
  page.table(
      {{"", "structure", "error, training [" + unit + "]", "error, validation [" + unit + "]", "fit [%]"},
       {"declared (before)", joined(r.declared.structure, " + "), number(r.declared.train_rmse),
        number(r.declared.validation_rmse), number(r.declared.fit_percent)},
       {"with the effects found (after)", joined(r.final_model.structure, " + "), number(r.final_model.train_rmse),
        number(r.final_model.validation_rmse), number(r.final_model.fit_percent)}});
  page.paragraph("For the final model the validation error is " + number(r.validation_over_training) +
                 " times the training error.");
}

std::string interval_text(const Interval& interval) {
  return number(interval.value) + " [" + number(interval.low) + ", " + number(interval.high) + "]";
}

/// The findings in sentences for pilots.
std::vector<std::string> sentences(const IdentifyResult& r) {
  std::vector<std::string> out;
  for (const EffectResult& effect : r.effects) {
    if (const std::string meaning = of_effect(effect.name, [](const auto& row) { return row.sentence; });
        !meaning.empty()) {
      out.push_back(effect.name + ": " + meaning);
    }
  }
  for (const std::vector<std::string>& group : r.not_separable) {
    out.push_back("These data cannot tell apart: " + joined(group, " and ") + ".");
  }
  for (const Change& change : r.changes) {
    out.push_back(change.name + " changed in mid-flight, at " + number(change.at_s) + " s (between " +
                  number(change.low_s) + " and " + number(change.high_s) + " s)" +
                  (change.size ? ", by " + interval_text(*change.size) : "") + ".");
  }
  for (const Refitted& one : r.refitted) {
    if (one.matters) {
      out.push_back(one.parameter + ": believed " + number(one.believed) + ", found " + interval_text(one.found) + ".");
    }
  }
  for (const Finding& finding : r.findings) {
    out.push_back((finding.what == "note" ? "" : finding.what + ": ") + finding.text);
  }
  return out;
}

/// A figure over time without lines; the validation part is shaded. @param suffix "" or "_x", ... of a translation.
plot::Figure over_time(const IdentifyResult& r, const std::string& suffix, const std::string& title,
                       const std::string& what) {
  return {.title = title,
          .x_label = "time [s]",
          .y_label = what + (suffix.empty() ? "" : " " + suffix.substr(1)) + " [" + unit_of(r.axis) + "]",
          .spans = validation_spans(r.figures),
          .link = "time"};
}

void add_series(plot::Figure& figure, const IdentifyResult& r, const std::string& key, const std::string& label,
                const char* color) {
  if (const Series* series = series_named(r, key); series != nullptr) {
    figure.lines.push_back(
        {.name = label, .x = r.figures.t_s, .y = series->values, .color = color, .max_step = kGap_s});
  }
}

/// Measured and both models.
void time_figure(plot::Page& page, const IdentifyResult& r, const std::string& suffix) {
  if (series_named(r, "measured" + suffix) == nullptr || r.figures.t_s.empty()) {
    return;
  }
  plot::Figure against = over_time(r, suffix, "Measured against both models", r.axis);
  add_series(against, r, "measured" + suffix, "measured", plot::kBlack);
  add_series(against, r, "declared" + suffix, "declared model", plot::kOrange);
  add_series(against, r, "final" + suffix, "with the effects found", plot::kBlue);
  page.figure(against, "Each model restarts from the measured state every 2.5 s.");
}

void residual_figures(plot::Page& page, const IdentifyResult& r) {
  for (const std::string suffix : {"", "_x", "_y", "_z"}) {
    if (suffix == "_y" || suffix == "_z") {
      time_figure(page, r, suffix);
    }
    plot::Figure left = over_time(r, suffix, "Residual: measured minus model", "residual");
    add_series(left, r, "declared_residual" + suffix, "declared model", plot::kOrange);
    add_series(left, r, "final_residual" + suffix, "with the effects found", plot::kBlue);
    if (!left.lines.empty() && !r.figures.t_s.empty()) {
      page.figure(left, "The part of the measurement that each model does not explain.");
    }
  }
}

void summary(plot::Page& page, const IdentifyResult& r, const ReportOrigin& origin) {
  const std::string misread = misreading(r);
  page.begin_answer({{"Refused", misread.empty() ? "" : "not fit to fly, because the log is misread: " + misread + "."},
                     {"Asked", "what does the declared model of " + r.axis + " (" +
                                   joined(r.declared.structure, " + ") + ") lack, by the log " + origin.log + "?"},
                     {"Missing in the model", missing(r)},
                     {"What it explains", explained(r)},
                     {"What it changes in flight", "not flown here: m100-lab loop flies both models."},
                     {"What remains", remains(r)}},
                    !misread.empty() || (r.verdict == "unexplained" && r.effects.empty()) ? "bad"
                    : r.verdict == "unexplained" || has_pattern(r)                        ? "warn"
                                                                                          : "good");
  time_figure(page, r, r.axis == "translation" ? "_x" : "");
  page.end_answer();
  page.paragraph((origin.train == origin.validation
                      ? "Trained and validated on parts in turn (" + origin.train + ")"
                      : "Trained on " + origin.train + ", validated on " + origin.validation) +
                 ". All errors are simulation errors over blocks of 2.5 s; each block starts from the measured state.");
  errors_table(page, r);
  const std::vector<std::string> means = sentences(r);
  if (!means.empty()) {
    page.heading("What it means for the flight");
    page.list(means);
  }
}

void effect_table(plot::Page& page, const IdentifyResult& r) {
  if (r.effects.empty()) {
    return;
  }
  page.heading("Effects in the order in which they were accepted");
  std::vector<std::vector<std::string>> rows{{"effect", "parameters [95 %]", "validation after", "cross-validated gain",
                                              "ΔBIC", "rivals within 5 %", "in flight"}};
  for (const EffectResult& effect : r.effects) {
    std::vector<std::string> parameters;
    for (const NamedInterval& p : effect.parameters) {
      parameters.push_back(p.name + " " + interval_text(p.interval));
    }
    std::vector<std::string> rivals;
    std::ranges::transform(effect.rivals, std::back_inserter(rivals), &Rival::name);
    rows.push_back({effect.name + (effect.shape.empty() ? "" : " (" + effect.shape + ")"), joined(parameters, "; "),
                    number(effect.validation_rmse_after), number(100 * effect.cv_gain) + " %", number(effect.delta_bic),
                    rivals.empty() ? "none" : joined(rivals, ", "),
                    of_effect(effect.name, [](const auto& row) { return words(row.in_flight); })});
  }
  page.table(rows);
}

void autocorrelations(plot::Page& page, const IdentifyResult& r) {
  const Figures& f = r.figures;
  if (!f.lag_s.empty()) {
    const double white = 1.96 / std::sqrt(std::max(1.0, static_cast<double>(f.t_s.size())));
    page.figure(
        plot::Figure{
            .title = "Autocorrelation of the residual",
            .x_label = "lag [s]",
            .y_label = "correlation",
            .lines =
                {{.name = "declared model", .x = f.lag_s, .y = f.declared_autocorrelation, .color = plot::kOrange},
                 {.name = "with the effects found", .x = f.lag_s, .y = f.final_autocorrelation, .color = plot::kBlue}},
            .levels = {{white, "95 % of white noise"}, {-white, ""}, {0.0, ""}},
            .height = 230},
        "White noise would stay inside the band from the first lag; air and autopilot make the residual coloured.");
  }
}

void candidates_figure(plot::Page& page, const IdentifyResult& r) {
  if (r.candidates.empty()) {
    return;
  }
  plot::BarChart chart{.title = "Candidates of the first round: cross-validated reduction of the error",
                       .x_label = "gain [% of mean square]"};
  for (const CandidateRow& row : r.candidates) {
    if (row.round == 0) {
      chart.bars.push_back({.label = row.name,
                            .value = 100 * std::max(row.cv_gain, -0.2),
                            .note = plot::percent(row.cv_gain) + (row.winner ? "  taken" : ""),
                            .color = row.winner ? plot::kGreen : (row.accepted ? plot::kBlue : plot::kGrey)});
    }
  }
  std::stable_sort(chart.bars.begin(), chart.bars.end(),
                   [](const auto& a, const auto& b) { return a.value > b.value; });
  page.figure(chart, "Green: accepted; blue: passes every test but is not the best; grey: fails a test.");
}

void intervals_figure(plot::Page& page, const IdentifyResult& r) {
  if (r.final_intervals.empty()) {
    return;
  }
  plot::IntervalChart chart{.title = "Parameters of the final model, 95 %, block jackknife"};
  for (const NamedInterval& p : r.final_intervals) {
    chart.rows.push_back({.label = p.name, .value = p.interval.value, .low = p.interval.low, .high = p.interval.high});
  }
  page.figure(chart,
              "Dot: estimate; bar: interval in per cent of the estimate. A long bar is an uncertain number; a bar that "
              "reaches the edge continues beyond it.");
}

void horizon_figure(plot::Page& page, const IdentifyResult& r, const std::string& what, const std::string& unit,
                    HorizonErrors ModelResult::*errors) {
  if ((r.final_model.*errors).front() == 0.0) {
    return;
  }
  plot::Figure figure{.title = what + " by horizon (validation)",
                      .x_label = "horizon [s]",
                      .y_label = "error [" + unit + "]",
                      .height = 230};
  const auto add = [&](const ModelResult& model, const char* name, const char* color) {
    figure.lines.push_back({.name = name,
                            .x = {kHorizons_s.begin(), kHorizons_s.end()},
                            .y = {(model.*errors).begin(), (model.*errors).end()},
                            .color = color,
                            .width = 2.2});
  };
  add(r.declared, "declared model", plot::kOrange);
  add(r.final_model, "with the effects found", plot::kBlue);
  figure.levels.emplace_back(0.0, "");
  page.figure(figure, "Root mean square prediction error at each time after the start of the prediction.");
}

}  // namespace

std::string misreading(const IdentifyResult& result) {
  for (const Finding& finding : result.findings) {
    if (finding.certain && std::ranges::count(kMisreadings, finding.what) > 0) {
      return finding.text;
    }
  }
  return "";
}

plot::Page report_page(const IdentifyResult& result, const ReportOrigin& origin) {
  plot::Page page("Identification: " + result.axis);
  summary(page, result, origin);
  effect_table(page, result);
  remainder_figures(page, result, unit_of(result.axis));
  page.heading("Figures");
  residual_figures(page, result);
  autocorrelations(page, result);
  specialist_figures(page, result);
  candidates_figure(page, result);
  intervals_figure(page, result);
  horizon_figure(page, result, "Prediction error", unit_of(result.axis), &ModelResult::horizon_rmse);
  horizon_figure(page, result, "Error of the position from the sticks", "m", &ModelResult::position_rmse);
  return page;
}

std::string write_report(const IdentifyResult& result, const ReportOrigin& origin, const std::string& directory) {
  std::string path = directory + "/" + result.axis + ".html";
  report_page(result, origin).write(path);
  write_series(result, directory + "/" + result.axis + ".csv");
  return path;
}

}  // namespace m100::lab::identify
