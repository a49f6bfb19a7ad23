// SPDX-License-Identifier: BSD-3-Clause
// The loop's page: believed and found parameters, and what the new file changed.
#include "host_tests/lab/loop/page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host_tests/lab/loop/results.h"
#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::loop {
namespace {

constexpr double kWorse = 1.02;  ///< after over before; above it a cell misses its goal

constexpr const char* kNothing = "nothing";
constexpr const char* kNothingThatMatters = "none that matters";

using Errors = std::array<double, kHorizons_s.size()>;

std::string change(double before, double after) { return before > 0.0 ? plot::percent(after / before - 1.0) : ""; }

void predictions(const LoopResult& result, plot::Page& page) {
  page.heading("Prediction error on a third flight, which no fit and no decision used");
  std::vector<std::vector<std::string>> rows{{"root mean square", "ahead [s]", "before", "after", "change"}};
  plot::Cells worse;
  for (const Quantity& quantity : kQuantities) {
    const Errors& before = result.before.prediction.*quantity.member;
    const Errors& after = result.after.prediction.*quantity.member;
    plot::Figure figure{.title = std::string("Prediction of ") + quantity.name,
                        .x_label = "ahead [s]",
                        .y_label = quantity.name,
                        .lines = {{.name = "before", .x = {}, .y = {}, .color = plot::kOrange},
                                  {.name = "after", .x = {}, .y = {}, .color = plot::kBlue}},
                        .y_range = std::pair{0.0, 1.1 * std::max(*std::max_element(before.begin(), before.end()),
                                                                 *std::max_element(after.begin(), after.end()))},
                        .height = 180.0};
    for (std::size_t i = 0; i < kHorizons_s.size(); ++i) {
      if (after[i] > kWorse * before[i]) {
        worse.insert({rows.size(), 3});
      }
      rows.push_back({quantity.name, plot::number(kHorizons_s[i]), plot::number(before[i]), plot::number(after[i]),
                      change(before[i], after[i])});
      figure.lines[0].x.push_back(kHorizons_s[i]);
      figure.lines[0].y.push_back(before[i]);
      figure.lines[1].x.push_back(kHorizons_s[i]);
      figure.lines[1].y.push_back(after[i]);
    }
    page.figure(figure, std::string("Error against the prediction horizon: ") + quantity.name);
  }
  page.table(rows, worse);
}

/// The largest distance inside the window of the RMS; on the way to the course, before it, distances are far larger.
double largest(const experiments::TaskResult& before, const experiments::TaskResult& after) {
  double most = 1e-3;
  for (const experiments::TaskResult* const one : {&before, &after}) {
    for (const experiments::TracePoint& p : one->trace) {
      const double d = std::hypot(p.position_m[0] - p.reference_m[0], p.position_m[1] - p.reference_m[1],
                                  p.position_m[2] - p.reference_m[2]);
      most = p.t_s >= one->task->from_s && p.t_s < one->task->to_s ? std::max(most, d) : most;
    }
  }
  return most;
}

plot::Curve distance(const char* name, const experiments::Trace& trace, const char* color) {
  plot::Curve line{.name = name, .x = {}, .y = {}, .color = color};
  for (const experiments::TracePoint& point : trace) {
    line.x.push_back(point.t_s);
    line.y.push_back(std::hypot(point.position_m[0] - point.reference_m[0], point.position_m[1] - point.reference_m[1],
                                point.position_m[2] - point.reference_m[2]));
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
  const std::size_t count = std::min(result.before.experiments.size(), result.after.experiments.size());
  for (std::size_t i = 0; i < count; ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    if (after.refused > 0 || after.mean.pose_m > kWorse * before.mean.pose_m) {
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
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    if (before.trace.empty() || after.trace.empty()) {
      continue;
    }
    page.figure(distance_figure(result, i), "Distance from the reference over time, first seed.");
  }
}

/// For each parameter: the believed value as a square, the value that the fit found as a dot on its 95 % interval.
plot::IntervalChart chart_of(const std::string& channel, const std::vector<identify::Refitted>& rows) {
  plot::IntervalChart chart{.title = channel + ": believed (square) and found (dot, 95 %)", .rows = {}};
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
    std::string names;
    for (const identify::EffectResult& effect : one.effects) {
      names += (names.empty() ? "" : ", ") + effect.name;
    }
    std::string left;
    for (const std::string& sentence : one.unexplained) {
      left += (left.empty() ? "" : "; ") + sentence;
    }
    rows.push_back({axis, one.verdict, names.empty() ? "nothing" : names, plot::number(one.declared.validation_rmse),
                    plot::number(one.final_model.validation_rmse), left});
  }
  page.table(rows);
  page.heading("Decisions");
  page.list(result.decisions);
}

/// Tasks that were flown worse: the mean of the trajectory may fall while another task gets worse.
std::string flown_worse(const LoopResult& result) {
  std::string out;
  const std::size_t count = std::min(result.before.experiments.size(), result.after.experiments.size());
  for (std::size_t i = 0; i < count; ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    if (before.refused == 0 && after.refused == 0 && after.mean.pose_m > kWorse * before.mean.pose_m) {
      out += (out.empty() ? "" : "; ") + before.task->task + ", " + before.task->condition + ", " +
             plot::number(before.mean.pose_m) + " m before, " + plot::number(after.mean.pose_m) + " m after";
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

constexpr std::size_t kOneSecond = 2;
static_assert(kHorizons_s[kOneSecond] == 1.0);

std::string joined(const std::vector<std::string>& sentences) {
  std::string out;
  for (const std::string& sentence : sentences) {
    out += (out.empty() ? "" : "; ") + sentence;
  }
  return out;
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
  return joined(out) + ".";
}

std::string explained(const LoopResult& result) {
  std::vector<std::string> out;
  for (const Quantity& quantity : kQuantities) {
    const double before = (result.before.prediction.*quantity.member)[kOneSecond];
    const double after = (result.after.prediction.*quantity.member)[kOneSecond];
    out.push_back(std::string(quantity.name) + " " + plot::number(before) + " to " + plot::number(after) + " (" +
                  change(before, after) + ")");
  }
  return "prediction 1 s ahead on a flight that no fit has seen: " + joined(out) + ".";
}

/// What became worse, with the margins of both laws (a slower law is safer), and what no effect explains.
std::vector<std::string> remains(const LoopResult& result) {
  std::vector<std::string> out;
  for (const std::string& cell : trajectory_errors(result).diverged) {
    out.push_back("diverged: " + cell + " (not in the mean)");
  }
  for (const std::string& sentence : predicted_worse(result)) {
    out.push_back(sentence);
  }
  if (const std::string tasks = flown_worse(result); !tasks.empty()) {
    out.push_back("worse tracking: " + tasks);
    for (const std::string& sentence : verdicts(result)) {
      if (sentence.starts_with("margins on the corrected model")) {
        out.push_back(sentence);
      }
    }
  }
  for (const auto& [axis, one] : result.identified) {
    if (!one.unexplained.empty()) {
      out.push_back(axis + ": unexplained: " + joined(one.unexplained));
    }
  }
  return out;
}

/// Index of the task whose figure is beside the answer: the trajectory, or else the first flown before and after.
std::size_t shown_task(const LoopResult& result) {
  const std::size_t count = std::min(result.before.experiments.size(), result.after.experiments.size());
  std::size_t shown = result.before.experiments.size();
  for (std::size_t i = count; i-- > 0;) {
    const bool flown = !result.before.experiments[i].trace.empty() && !result.after.experiments[i].trace.empty();
    const bool better = shown == result.before.experiments.size() ||
                        result.before.experiments[shown].task->task != "trajectory" ||
                        result.before.experiments[i].task->task == "trajectory";
    shown = flown && better ? i : shown;
  }
  return shown;
}

/// The result in one table: missing effects, wrong numbers, their certainty, and their effect on the prediction.
void answer(const LoopResult& result, plot::Page& page) {
  std::vector<std::vector<std::string>> rows{{"channel", "effects that the file lacks", "numbers that are wrong",
                                              "1 s ahead, before", "after", "change", "taken over"}};
  plot::Cells worse;
  for (const Quantity& quantity : kQuantities) {
    const auto found = result.identified.find(quantity.channel);
    if (found == result.identified.end()) {
      continue;
    }
    const double before = (result.before.prediction.*quantity.member)[kOneSecond];
    const double after = (result.after.prediction.*quantity.member)[kOneSecond];
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
  page.begin_answer({{"Asked",
                      "which numbers of the vehicle file are wrong, and do the numbers found from the log predict and "
                      "fly the aircraft "
                      "better?"},
                     {"Missing in the model", missing_in_file(result)},
                     {"What it explains (simulated)", explained(result)},
                     {"What it changed in flight (simulated)",
                      errors.cells > 0 ? "pose error on the trajectory: " + plot::number(errors.before_m) +
                                             " m before, " + plot::number(errors.after_m) + " m after (" +
                                             change(errors.before_m, errors.after_m) + ")."
                                       : "pose error on the trajectory: not flown."},
                     {"What remains", left.empty() ? "nothing became worse." : joined(left) + "."}},
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
