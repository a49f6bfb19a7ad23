// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/motion.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::experiments {
namespace {

constexpr std::array kFactors{0.125, 0.24, 0.5, 1.0, 2.0, 4.0};

Cell calm_cell(SuiteOptions options, const char* task) {
  options.only = task;
  options.literal_steps = false;
  for (const TaskResult& result : fly_suite(options)) {
    if (result.task->condition == "calm") {
      return result.mean;
    }
  }
  return {};
}

/// From the calmest to the fastest: x must not decrease.
plot::Line line_of(const std::vector<MotionPoint>& points, Cell MotionPoint::*task, const char* name,
                   const char* color) {
  plot::Line line{.name = name, .x = {}, .y = {}, .color = color};
  for (auto point = points.rbegin(); point != points.rend(); ++point) {
    line.x.push_back(((*point).*task).input_variation_deg_s);
    line.y.push_back(1e3 * ((*point).*task).pose_m);
  }
  return line;
}

}  // namespace

std::vector<MotionPoint> fly_motion(const SuiteOptions& options) {
  std::vector<MotionPoint> points;
  for (const double factor : kFactors) {
    SuiteOptions one = options;
    one.vehicle.vehicle.mpc.input *= factor;
    points.push_back({.input_weight = one.vehicle.vehicle.mpc.input,
                      .hover = calm_cell(one, "hover"),
                      .square = calm_cell(one, "trajectory")});
  }
  return points;
}

void print_motion(std::ostream& out, const std::vector<MotionPoint>& points) {
  out << "input weight   hover: command [deg/s], pose [m]   square: command [deg/s], pose [m]\n";
  for (const MotionPoint& point : points) {
    char line[160];
    std::snprintf(line, sizeof line, "%12.2f %18.1f %13.4f %24.1f %13.4f\n", point.input_weight,
                  point.hover.input_variation_deg_s, point.hover.pose_m, point.square.input_variation_deg_s,
                  point.square.pose_m);
    out << line;
  }
}

nlohmann::json motion_to_json(const std::vector<MotionPoint>& points) {
  nlohmann::json all = nlohmann::json::array();
  const auto one = [](const Cell& cell) {
    return nlohmann::json{{"pose_m", cell.pose_m}, {"command_deg_s", cell.input_variation_deg_s}};
  };
  for (const MotionPoint& point : points) {
    all.push_back({{"input_weight", point.input_weight}, {"hover", one(point.hover)}, {"square", one(point.square)}});
  }
  return all;
}

void write_motion_report(const std::string& folder, const std::vector<MotionPoint>& points, const std::string& about) {
  plot::Page page("What calm commands cost in tracking error, simulated");
  page.paragraph(about);
  page.raw(plot::svg(plot::Figure{.title = "One point for each input weight",
                                  .x_label = "motion of both tilt commands together [deg/s]",
                                  .y_label = "pose error [mm rms]",
                                  .lines = {line_of(points, &MotionPoint::hover, "hover", plot::kBlue),
                                            line_of(points, &MotionPoint::square, "square of 1 m", plot::kOrange)}}));
  std::vector<std::vector<std::string>> rows{
      {"input weight", "hover [deg/s]", "hover [m]", "square [deg/s]", "square [m]"}};
  for (const MotionPoint& point : points) {
    rows.push_back({plot::number(point.input_weight), plot::number(point.hover.input_variation_deg_s),
                    plot::number(point.hover.pose_m), plot::number(point.square.input_variation_deg_s),
                    plot::number(point.square.pose_m)});
  }
  page.table(rows);
  page.write(folder + "/motion.html");
}

}  // namespace m100::lab::experiments
