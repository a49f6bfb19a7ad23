// SPDX-License-Identifier: BSD-3-Clause
// The loop's page: what was believed, what was found, what it changed.
#include <algorithm>
#include <array>
#include <cmath>

#include "host_tests/lab/loop/close_loop.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::loop {
namespace {

using Errors = std::array<double, kHorizons_s.size()>;

struct Quantity {
  const char* name;
  Errors Prediction::*member;
};
constexpr std::array<Quantity, 4> kQuantities{{{"roll [rad]", &Prediction::roll_rad},
                                               {"pitch [rad]", &Prediction::pitch_rad},
                                               {"horizontal velocity [m/s]", &Prediction::velocity_m_s},
                                               {"climb speed [m/s]", &Prediction::climb_m_s}}};

std::string change(double before, double after) {
  return before > 0.0 ? plot::number(100.0 * (after / before - 1.0)) + " %" : "";
}

void predictions(const LoopResult& result, plot::Page& page) {
  page.heading("Prediction error on the second identification flight, which no fit has seen");
  std::vector<std::vector<std::string>> rows{{"root mean square", "ahead [s]", "before", "after", "change"}};
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
      rows.push_back({quantity.name, plot::number(kHorizons_s[i]), plot::number(before[i]), plot::number(after[i]),
                      change(before[i], after[i])});
      figure.lines[0].x.push_back(kHorizons_s[i]);
      figure.lines[0].y.push_back(before[i]);
      figure.lines[1].x.push_back(kHorizons_s[i]);
      figure.lines[1].y.push_back(after[i]);
    }
    page.figure(plot::svg(figure), std::string("Error against the age of the prediction: ") + quantity.name);
  }
  page.table(rows);
}

plot::Line distance(const char* name, const experiments::Trace& trace, const char* color) {
  plot::Line line{.name = name, .x = {}, .y = {}, .color = color};
  for (const experiments::TracePoint& point : trace) {
    double square = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      square += (point.position_m[c] - point.reference_m[c]) * (point.position_m[c] - point.reference_m[c]);
    }
    line.x.push_back(point.t_s);
    line.y.push_back(std::sqrt(square));
  }
  return line;
}

void tracking(const LoopResult& result, plot::Page& page) {
  page.heading("Tracking: the tasks flown with the vehicle file before and after");
  std::vector<std::vector<std::string>> rows{
      {"task", "air", "pose before [m]", "after [m]", "change", "tilt before [deg]", "after [deg]"}};
  const std::size_t count = std::min(result.before.experiments.size(), result.after.experiments.size());
  for (std::size_t i = 0; i < count; ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    rows.push_back({before.task->task, before.task->condition,
                    before.refused > 0 ? "no control" : plot::number(before.mean.pose_m),
                    after.refused > 0 ? "no control" : plot::number(after.mean.pose_m),
                    change(before.mean.pose_m, after.mean.pose_m), plot::number(before.mean.tilt_deg),
                    plot::number(after.mean.tilt_deg)});
  }
  page.table(rows);
  for (std::size_t i = 0; i < count; ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    if (before.trace.empty() || after.trace.empty()) {
      continue;
    }
    plot::Figure figure{
        .title = before.task->task + ", " + before.task->condition + " (simulated)",
        .x_label = "time [s]",
        .y_label = "distance from the reference [m]",
        .lines = {distance("before", before.trace, plot::kOrange), distance("after", after.trace, plot::kBlue)},
        .height = 200.0};
    figure.spans.push_back({before.task->from_s, before.task->to_s, "window of the RMS"});
    page.figure(plot::svg(figure), "Distance from the reference over time, first seed.");
  }
}

void found(const LoopResult& result, plot::Page& page) {
  page.heading("What the logs said");
  std::vector<std::vector<std::string>> rows{{"axis", "verdict", "named", "error declared", "error final", "left"}};
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

}  // namespace

void write_page(const LoopResult& result, const std::string& file) {
  plot::Page page("Closing the loop: believed, found, flown again");
  const double before = trajectory_error_m(result.before.experiments);
  const double after = trajectory_error_m(result.after.experiments);
  page.verdict("Pose error on the trajectory: " + plot::number(before) + " m before, " + plot::number(after) +
                   " m after (" + change(before, after) + ").",
               after < before           ? "good"
               : after <= 1.05 * before ? "warn"
                                        : "bad");
  page.paragraph(
      "All flights are simulated. The plant was shown to the simulator only: the new vehicle file comes from the logs "
      "of two identification flights, the second of which no fit has seen.");
  found(result, page);
  predictions(result, page);
  tracking(result, page);
  page.write(file);
}

}  // namespace m100::lab::loop
