// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/report.h"

#include <algorithm>
#include <array>

#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::experiments {
namespace {

template <typename Get>
plot::Curve line(const std::string& name, const Trace& trace, Get get, const char* color, bool dashed = false) {
  plot::Curve out{.name = name, .color = color, .dashed = dashed};
  for (const TracePoint& point : trace) {
    out.x.push_back(point.t_s);
    out.y.push_back(get(point));
  }
  return out;
}

plot::Figure position_figure(const TaskResult& result) {
  plot::Figure figure{.title = result.task->task + ", " + result.task->condition + ": position (simulated)",
                      .x_label = "time [s]",
                      .y_label = "position [m]",
                      .link = result.task->task + result.task->condition};
  constexpr std::array kNames{"x", "y", "z"};
  constexpr std::array kColors{plot::kBlue, plot::kOrange, plot::kGreen};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    figure.lines.push_back(line(
        kNames[axis], result.trace, [axis](const TracePoint& p) { return p.position_m[axis]; }, kColors[axis]));
    const auto reference = [axis](const TracePoint& p) { return p.reference_m[axis]; };
    const std::string name = std::string(kNames[axis]) + ", reference";
    figure.lines.push_back(line(name, result.trace, reference, plot::kBlack, true));
  }
  figure.spans.push_back({result.task->from_s, result.task->to_s, "window of the RMS"});
  return figure;
}

/// @param above receives our cells that are above the paper's
std::vector<std::vector<std::string>> table(const std::vector<TaskResult>& results, plot::Cells& above) {
  constexpr std::array kColumns{"", "", "pose_m", "x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg"};
  std::vector<std::vector<std::string>> rows{{"task", "", "pose [m]", "x [m]", "y [m]", "z [m]", "roll [deg]",
                                              "pitch [deg]", "yaw [deg]", "tilt [deg]", "command moves [deg/s]",
                                              "of time-optimal"}};
  const auto cell = [](double value) { return value < 0.0 ? std::string("-") : plot::number(value); };
  for (const TaskResult& result : results) {
    const std::string name = result.task->task + ", " + result.task->condition;
    if (const model::paper::ResultColumn* const p = result.task->paper) {
      rows.push_back({name, "paper", cell(p->pose_m), cell(p->x_m), cell(p->y_m), cell(p->z_m), cell(p->roll_deg),
                      cell(p->pitch_deg), cell(p->yaw_deg), "-", "-", "-"});
    }
    for (const PaperComparison& one : compared(result)) {
      const auto column = std::find(kColumns.begin(), kColumns.end(), one.name);
      if (one.above && column != kColumns.end()) {
        above.insert({rows.size(), static_cast<std::size_t>(column - kColumns.begin())});
      }
    }
    const auto add = [&](const std::string& flown, const Cell& c, const std::string& share) {
      rows.push_back({name, flown, cell(c.pose_m), cell(c.x_m), cell(c.y_m), cell(c.z_m), cell(c.roll_deg),
                      cell(c.pitch_deg), cell(c.yaw_deg), cell(c.tilt_deg), cell(c.input_variation_deg_s), share});
    };
    add("simulated", result.mean,
        result.time_optimal_m > 0.0 ? plot::number(100.0 * result.time_optimal_share) + " %" : "-");
    if (result.baseline) {
      add("simulated, clipped LQR", *result.baseline, "-");
    }
  }
  return rows;
}

}  // namespace

std::string page_name(const Task& task) { return "flight_" + task.task + "_" + task.condition + ".html"; }

void write_report(const std::string& folder, const std::vector<TaskResult>& results, const std::string& about) {
  plot::Page page("Flights: the paper's tasks, simulated");
  page.paragraph(about);
  const int above = cells_above_paper(results);
  page.verdict(above == 0 ? "Every cell is at or below the paper's value."
                          : std::to_string(above) + " cells above the paper's value" + above_words(results) + ".",
               above == 0 ? "good" : "warn");
  plot::Cells marked;
  const auto rows = table(results, marked);
  page.table(rows, marked);
  for (const TaskResult& result : results) {
    page.heading(result.task->task + ", " + result.task->condition);
    page.figure(position_figure(result),
                "Position of the first seed; dashed: reference. Everything else of this flight: " +
                    page_name(*result.task) + ".");
  }
  page.write(folder + "/experiments.html");
}

}  // namespace m100::lab::experiments
