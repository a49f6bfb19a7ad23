// SPDX-License-Identifier: BSD-3-Clause
// The loop's page: believed and found parameters, and what the new file changed.
#include "host_tests/lab/loop/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "host_tests/lab/loop/paired_flights.h"
#include "host_tests/lab/loop/results.h"
#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::loop {
namespace {

constexpr double kWorse = 1.02;  ///< of a prediction error, after over before; above it a table cell is marked as worse

constexpr const char* kNothing = "nothing";
constexpr const char* kNothingThatMatters = "none that matters";

using Errors = identify::HorizonErrors;

std::string change(double before, double after) { return before > 0.0 ? plot::percent(after / before - 1.0) : ""; }

plot::Curve curve(const char* name, const Errors& of, const char* color) {
  return {.name = name,
          .x = {identify::kHorizons_s.begin(), identify::kHorizons_s.end()},
          .y = {of.begin(), of.end()},
          .color = color};
}

void predictions(const LoopResult& result, plot::Page& page) {
  page.heading("Prediction error on a third flight, which no fit and no decision used");
  std::vector<std::vector<std::string>> rows{{"root mean square", "ahead [s]", "before", "after", "change"}};
  plot::Cells worse;
  for (const identify::Quantity& quantity : identify::kQuantities) {
    const Errors& before = result.before.prediction.*quantity.member;
    const Errors& after = result.after.prediction.*quantity.member;
    plot::Figure figure{.title = std::string("Prediction of ") + quantity.name,
                        .x_label = "ahead [s]",
                        .y_label = "error, root mean square",
                        .lines = {curve("before", before, plot::kOrange), curve("after", after, plot::kBlue)},
                        .y_range = std::pair{0.0, 1.1 * std::max(*std::max_element(before.begin(), before.end()),
                                                                 *std::max_element(after.begin(), after.end()))},
                        .height = 180.0};
    for (std::size_t i = 0; i < identify::kHorizons_s.size(); ++i) {
      if (after[i] > kWorse * before[i]) {
        worse.insert({rows.size(), 3});
      }
      rows.push_back({quantity.name, plot::number(identify::kHorizons_s[i]), plot::number(before[i]),
                      plot::number(after[i]), change(before[i], after[i])});
    }
    page.figure(figure, "");
  }
  page.table(rows, worse);
}

double distance_m(const experiments::TracePoint& p) {
  return std::hypot(p.position_m[0] - p.reference_m[0], p.position_m[1] - p.reference_m[1],
                    p.position_m[2] - p.reference_m[2]);
}

/// The largest distance from the reference inside the window of the RMS, at least 1 mm.
double largest(const experiments::TaskResult& before, const experiments::TaskResult& after) {
  double most = 1e-3;
  for (const experiments::TaskResult* const one : {&before, &after}) {
    for (const experiments::TracePoint& p : one->trace) {
      most = p.t_s >= one->task->from_s && p.t_s < one->task->to_s ? std::max(most, distance_m(p)) : most;
    }
  }
  return most;
}

plot::Curve distance(const char* name, const experiments::Trace& trace, const char* color) {
  plot::Curve line{.name = name, .color = color};
  for (const experiments::TracePoint& point : trace) {
    line.x.push_back(point.t_s);
    line.y.push_back(distance_m(point));
  }
  return line;
}

plot::Figure distance_figure(const LoopResult& result, std::size_t task) {
  const experiments::TaskResult& before = result.before.experiments[task];
  const experiments::TaskResult& after = result.after.experiments[task];
  return {.title = before.task->task + ", " + before.task->condition + " (simulated)",
          .x_label = "time [s]",
          .y_label = "distance from the reference [m]",
          .lines = {distance("before", before.trace, plot::kOrange), distance("after", after.trace, plot::kBlue)},
          .spans = {{before.task->from_s, before.task->to_s, "window of the RMS"}},
          .y_range = std::pair{0.0, 1.1 * largest(before, after)},
          .height = 200.0};
}

void tracking(const LoopResult& result, plot::Page& page) {
  page.heading("Tracking: the tasks flown with the vehicle file before and after");
  std::vector<std::vector<std::string>> rows{
      {"task", "air", "pose before [m]", "after [m]", "change", "tilt before [deg]", "after [deg]"}};
  plot::Cells worse;
  const auto pairs = compare_tasks(result.before.experiments, result.after.experiments);
  const std::size_t count = std::min(result.before.experiments.size(), result.after.experiments.size());
  for (std::size_t i = 0; i < count; ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    const auto paired = pairs.find(before.task->task);
    const bool is_worse = paired != pairs.end() && paired->second.is_worse();
    if (after.refused > 0 || (is_worse && after.mean.pose_m > before.mean.pose_m)) {
      worse.insert({rows.size(), 3});
    }
    rows.push_back({before.task->task, before.task->condition,
                    before.refused > 0 ? "no control" : plot::number(before.mean.pose_m),
                    after.refused > 0 ? "no control" : plot::number(after.mean.pose_m),
                    change(before.mean.pose_m, after.mean.pose_m), plot::number(before.mean.tilt_deg),
                    plot::number(after.mean.tilt_deg)});
  }
  page.table(rows, worse);
  page.list(verdicts(result));
  for (std::size_t i = 0; i < count; ++i) {
    if (!result.before.experiments[i].trace.empty() && !result.after.experiments[i].trace.empty()) {
      page.figure(distance_figure(result, i), "Distance from the reference over time, first seed.");
    }
  }
}

/// For each parameter: the believed value as a square, the value that the fit found as a dot on its 95 % interval.
plot::IntervalChart chart_of(const std::string& channel, const std::vector<identify::Refitted>& rows) {
  plot::IntervalChart chart{.title = channel + ": believed (square) and found (dot, 95 %)"};
  for (const identify::Refitted& one : rows) {
    chart.rows.push_back({.label = one.parameter,
                          .value = one.found.value,
                          .low = one.found.low,
                          .high = one.found.high,
                          .believed = one.believed,
                          .color = one.matters ? plot::kOrange : plot::kBlue});
  }
  return chart;
}

void believed_to_found(const LoopResult& result, plot::Page& page) {
  page.heading("Believed -> found");
  page.paragraph(
      "Orange: on a flight that no fit has seen, the believed value predicts at least 1 % worse than the found value.");
  std::vector<std::vector<std::string>> rows{
      {"channel", "parameter", "believed", "found", "95 % low", "high", "matters", "taken over"}};
  for (const auto& [channel, parameters] : result.believed_found) {
    if (!parameters.empty()) {
      page.figure(chart_of(channel, parameters),
                  "In per cent of the found value; what lies beyond the line is drawn at its end.");
    }
    for (const identify::Refitted& one : parameters) {
      rows.push_back({channel, one.parameter, plot::number(one.believed), plot::number(one.found.value),
                      plot::number(one.found.low), plot::number(one.found.high), one.matters ? "yes" : "no",
                      result.taken_over.count(channel) > 0 ? "yes" : "no"});
    }
  }
  page.table(rows);
}

void found(const LoopResult& result, plot::Page& page) {
  page.heading("What identification found in the logs");
  std::vector<std::vector<std::string>> rows{
      {"axis", "verdict", "named", "error declared", "error final", "unexplained"}};
  for (const auto& [axis, one] : result.identified) {
    std::vector<std::string> names;
    std::ranges::transform(one.effects, std::back_inserter(names), &identify::EffectResult::name);
    rows.push_back({axis, one.verdict, names.empty() ? "nothing" : plot::joined(names, ", "),
                    plot::number(one.declared.validation_rmse), plot::number(one.final_model.validation_rmse),
                    plot::joined(one.unexplained, "; ")});
  }
  page.table(rows);
  page.heading("Decisions");
  page.list(result.decisions);
}

/// The tasks that were flown worse, by the verdicts that the page lists.
std::vector<std::string> flown_worse(const LoopResult& result) {
  std::vector<std::string> out;
  for (const auto& [task, pairs] : compare_tasks(result.before.experiments, result.after.experiments)) {
    for (const auto& [part, errors] : {std::pair{"horizontal", &pairs.horizontal}, {"vertical", &pairs.vertical}}) {
      if (errors->is_worse()) {
        out.push_back("flown worse: " + task + ", " + part + ": " + describe(*errors));
      }
    }
  }
  return out;
}

std::string with_interval(const std::string& name, const identify::Interval& found) {
  return name + " " + plot::number(found.value) + " [" + plot::number(found.low) + ", " + plot::number(found.high) +
         "]";
}

std::string missing(const identify::IdentifyResult& one) {
  std::string out;
  for (const identify::EffectResult& effect : one.effects) {
    out += (out.empty() ? "" : "; ") + effect.name;
    for (const identify::NamedInterval& parameter : effect.parameters) {
      out += ", " + with_interval(parameter.name, parameter.interval);
    }
  }
  if (out.empty() && !one.unexplained.empty()) {
    return "an effect that could not be named";
  }
  return out.empty() ? kNothing : out;
}

std::string believed_wrongly(const std::vector<identify::Refitted>& parameters) {
  std::string out;
  for (const identify::Refitted& one : parameters) {
    if (one.matters) {
      out += (out.empty() ? "" : "; ") + one.parameter + " " + plot::number(one.believed) + " -> " +
             plot::number(one.found.value);
    }
  }
  return out.empty() ? kNothingThatMatters : out;
}

/// How many of a channel's believed numbers are wrong and matter (Refitted::matters), in words; empty: none.
std::string count_of_wrong(const LoopResult& result, const std::string& channel) {
  const auto believed = result.believed_found.find(channel);
  if (believed == result.believed_found.end()) {
    return "";
  }
  const auto wrong = std::ranges::count_if(believed->second, &identify::Refitted::matters);
  return wrong == 0 ? "" : std::to_string(wrong) + (wrong == 1 ? " wrong number" : " wrong numbers");
}

/// For each channel the missing effects and how many numbers are wrong (the table below has them); channels without
/// either are only named.
std::string missing_in_file(const LoopResult& result) {
  std::vector<std::string> out;
  std::string right;
  for (const auto& [channel, one] : result.identified) {
    const std::string wrong = count_of_wrong(result, channel);
    const std::string effects = missing(one);
    if (effects == kNothing && wrong.empty()) {
      right += (right.empty() ? "" : ", ") + channel;
    } else {
      out.push_back(channel + ": " + (effects == kNothing ? "no effect" : effects) +
                    (wrong.empty() ? "" : ", and " + wrong));
    }
  }
  if (!right.empty()) {
    out.push_back(right + ": nothing");
  }
  return plot::joined(out, "; ") + ".";
}

std::string explained(const LoopResult& result) {
  std::vector<std::string> out;
  for (const identify::Quantity& quantity : identify::kQuantities) {
    const double before = (result.before.prediction.*quantity.member)[identify::kOneSecond];
    const double after = (result.after.prediction.*quantity.member)[identify::kOneSecond];
    out.push_back(std::string(quantity.name) + " " + plot::number(before) + " to " + plot::number(after) + " (" +
                  change(before, after) + ")");
  }
  return "prediction 1 s ahead on a flight that no fit has seen: " + plot::joined(out, "; ") + ".";
}

/// What diverged or became worse, and what no effect explains. If a flown task is worse, also the margins of the laws.
std::vector<std::string> remains(const LoopResult& result) {
  std::vector<std::string> out;
  if (!result.is_kept) {
    out.emplace_back(kNotKept);
  }
  for (const std::string& cell : trajectory_errors(result).diverged) {
    out.push_back("diverged: " + cell + " (not in the mean)");
  }
  for (const std::string& sentence : predicted_worse(result)) {
    out.push_back(sentence);
  }
  if (const std::vector<std::string> tasks = flown_worse(result); !tasks.empty()) {
    out.insert(out.end(), tasks.begin(), tasks.end());
    for (const std::string& sentence : verdicts(result)) {
      if (sentence.starts_with("margins on the corrected model")) {
        out.push_back(sentence);
      }
    }
  }
  for (const auto& [axis, one] : result.identified) {
    if (!one.unexplained.empty()) {
      out.push_back(axis + ": unexplained: " + plot::joined(one.unexplained, "; "));
    }
  }
  return out;
}

/// Index of the task whose figure is beside the answer: the trajectory, or else the first flown before and after.
std::size_t shown_task(const LoopResult& result) {
  const auto& [before, after] = std::tie(result.before.experiments, result.after.experiments);
  for (const bool any : {false, true}) {
    for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
      if (!before[i].trace.empty() && !after[i].trace.empty() && (any || before[i].task->task == "trajectory")) {
        return i;
      }
    }
  }
  return before.size();
}

/// The result in one table: missing effects, wrong numbers, and the prediction error before and after.
void answer(const LoopResult& result, plot::Page& page) {
  std::vector<std::vector<std::string>> rows{{"channel", "effects that the file lacks", "numbers that are wrong",
                                              "1 s ahead, before", "after", "change", "taken over"}};
  plot::Cells worse;
  for (const identify::Quantity& quantity : identify::kQuantities) {
    const auto found = result.identified.find(quantity.channel);
    if (found == result.identified.end()) {
      continue;
    }
    const double before = (result.before.prediction.*quantity.member)[identify::kOneSecond];
    const double after = (result.after.prediction.*quantity.member)[identify::kOneSecond];
    if (after > kWorse * before) {
      worse.insert({rows.size(), 4});
    }
    const auto believed = result.believed_found.find(quantity.channel);
    const std::string effects = missing(found->second);
    const std::string numbers = believed == result.believed_found.end() ? "" : believed_wrongly(believed->second);
    const bool has_news = effects != kNothing || (!numbers.empty() && numbers != kNothingThatMatters);
    rows.push_back({quantity.name, effects, numbers, plot::number(before), plot::number(after), change(before, after),
                    result.taken_over.count(quantity.channel) > 0 ? "yes"
                    : has_news                                    ? "no"
                                                                  : "nothing to take over"});
  }
  page.table(rows, worse);
}

}  // namespace

void write_page(const LoopResult& result, const std::string& file) {
  plot::Page page("Closing the loop: fly, identify, fly again");
  const std::vector<std::string> left = remains(result);
  const TrajectoryErrors errors = trajectory_errors(result);
  page.begin_answer(
      {{"Asked",
        "which numbers of the vehicle file are wrong, and do the numbers found from the log predict and "
        "fly the aircraft "
        "better?"},
       {"Missing in the model", missing_in_file(result)},
       {"What it explains (simulated)", explained(result)},
       {"What it changed in flight (simulated)",
        errors.cells > 0
            ? "pose error on the trajectory: " + plot::number(errors.before_m) + " m before, " +
                  plot::number(errors.after_m) + " m after (" + change(errors.before_m, errors.after_m) + "), " +
                  compare_tasks(result.before.experiments, result.after.experiments).at("trajectory").pose.verdict() +
                  " as flown. " + paired_rule()
            : "pose error on the trajectory: not flown."},
       {"What remains", left.empty() ? "nothing became worse." : plot::joined(left, "; ") + "."}},
      !errors.diverged.empty()           ? "bad"
      : left.empty() && errors.cells > 0 ? "good"
                                         : "warn");
  if (const std::size_t shown = shown_task(result); shown < result.before.experiments.size()) {
    page.figure(distance_figure(result, shown), "Distance from the reference, first seed.");
  }
  page.end_answer();
  answer(result, page);
  page.paragraph(
      "All flights are simulated, and only the simulator knows the plant. The new vehicle file was identified from the "
      "log of one flight. A second flight decided for each channel whether the new numbers are taken over, and the "
      "prediction errors are those of a third flight. Brackets are 95 % intervals; all parameters are listed below.");
  predictions(result, page);
  tracking(result, page);
  believed_to_found(result, page);
  found(result, page);
  page.write(file);
}

}  // namespace m100::lab::loop
