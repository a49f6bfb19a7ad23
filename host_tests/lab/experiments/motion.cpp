// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/motion.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::experiments {
namespace {

constexpr std::array kFactors{0.125, 0.24, 0.5, 1.0, 2.0, 4.0};  // 0.24 of the weight 12 is 2.88, an earlier weight

std::optional<Cell> calm_cell(SuiteOptions options, const char* task, int& refused) {
  options.only = task;
  options.condition = "calm";
  options.literal_steps = false;
  const std::vector<TaskResult> results = fly_suite(options);
  refused += results.front().refused;
  return results.front().flown() ? std::optional(results.front().mean) : std::nullopt;
}

/// A number of a cell as text; "not flown" without a cell.
std::string text(const std::optional<Cell>& cell, double Cell::*member, int digits) {
  char out[32];
  std::snprintf(out, sizeof out, "%.*f", digits, cell ? (*cell).*member : 0.0);
  return cell ? out : "not flown";
}

/// The curve from the largest input weight to the smallest, because its x, the command motion, must not decrease.
plot::Curve line_of(const std::vector<MotionPoint>& points, std::optional<Cell> MotionPoint::*task, const char* name,
                    const char* color) {
  plot::Curve line{.name = name, .color = color};
  for (auto point = points.rbegin(); point != points.rend(); ++point) {
    if (const std::optional<Cell>& cell = (*point).*task) {
      line.x.push_back(cell->input_variation_deg_s);
      line.y.push_back(1e3 * cell->pose_m);
    }
  }
  return line;
}

}  // namespace

std::vector<MotionPoint> fly_motion(const SuiteOptions& options) {
  std::vector<MotionPoint> points;
  for (const double factor : kFactors) {
    SuiteOptions one = options;
    model::flown_weights(one.vehicle.vehicle).input *= factor;
    MotionPoint point{
        .input_weight = model::flown_weights(one.vehicle.vehicle).input, .hover = {}, .square = {}, .refused = 0};
    point.hover = calm_cell(one, "hover", point.refused);
    point.square = calm_cell(one, "trajectory", point.refused);
    points.push_back(point);
  }
  return points;
}

void print_motion(std::ostream& out, const std::vector<MotionPoint>& points) {
  out << "input weight   hover: command [deg/s], pose [m]   square: command [deg/s], pose [m]\n";
  for (const MotionPoint& point : points) {
    char line[160];
    std::snprintf(
        line, sizeof line, "%12.2f %18s %13s %24s %13s\n", point.input_weight,
        text(point.hover, &Cell::input_variation_deg_s, 1).c_str(), text(point.hover, &Cell::pose_m, 4).c_str(),
        text(point.square, &Cell::input_variation_deg_s, 1).c_str(), text(point.square, &Cell::pose_m, 4).c_str());
    out << line;
  }
}

nlohmann::json motion_to_json(const std::vector<MotionPoint>& points) {
  nlohmann::json all = nlohmann::json::array();
  const auto one = [](const std::optional<Cell>& cell) {
    return cell ? nlohmann::json{{"pose_m", cell->pose_m}, {"command_deg_s", cell->input_variation_deg_s}}
                : nlohmann::json();
  };
  for (const MotionPoint& point : points) {
    all.push_back({{"input_weight", point.input_weight}, {"hover", one(point.hover)}, {"square", one(point.square)}});
  }
  return all;
}

void write_motion_report(const std::string& folder, const std::vector<MotionPoint>& points, const std::string& about) {
  plot::Page page("Tracking error against the motion of the command, simulated");
  page.paragraph(about);
  const plot::Figure curve{.title = "One point for each input weight",
                           .x_label = "motion of both tilt commands together [deg/s]",
                           .y_label = "pose error [mm rms]",
                           .lines = {line_of(points, &MotionPoint::hover, "hover", plot::kBlue),
                                     line_of(points, &MotionPoint::square, "square of 1 m", plot::kOrange)}};
  page.figure(curve, "Simulated.");
  std::vector<std::vector<std::string>> rows{
      {"input weight", "hover [deg/s]", "hover [m]", "square [deg/s]", "square [m]"}};
  for (const MotionPoint& point : points) {
    rows.push_back({plot::number(point.input_weight), text(point.hover, &Cell::input_variation_deg_s, 1),
                    text(point.hover, &Cell::pose_m, 4), text(point.square, &Cell::input_variation_deg_s, 1),
                    text(point.square, &Cell::pose_m, 4)});
  }
  page.table(rows);
  page.write(folder + "/motion.html");
  const std::string drawing = folder + "/motion.svg";
  std::ofstream out(drawing);
  out << plot::svg(curve);
  if (!out.flush()) {
    throw InputError(drawing, 0, "", "cannot be written");
  }
}

}  // namespace m100::lab::experiments
