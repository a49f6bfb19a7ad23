// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/course/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "firmware/core/maths.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::course {
namespace {

constexpr core::Duration::rep kPoints = 600;  ///< intervals between the points of a curve
constexpr double kSide = 430.0;               ///< width of each of the two columns, in pixels
constexpr double kCross = 0.015;              ///< half width of a cross, as a share of the visible range
constexpr double kAir = 0.05;                 ///< margin in x inside the frame, as a share of the visible range
constexpr double kNear = 1.0 / 3.0;  ///< share of the fence's larger side; a course up to it is drawn without the fence

using Range = std::pair<double, double>;

struct Samples {
  std::vector<double> t_s, x_m, y_m, z_m, speed_m_s, tilt_deg;
};

Samples samples_of(const ref::Trajectory<double>& course, const ref::Waypoint<double>& start) {
  Samples out;
  for (core::Duration::rep i = 0; i <= kPoints; ++i) {
    const core::Duration at = course.duration() * i / kPoints;
    const ref::Motion motion = course.motion(at, i == kPoints);
    const companion::MotionMagnitudes effort = companion::magnitudes_of(motion);
    out.t_s.push_back(core::seconds<double>(at));
    out.x_m.push_back(motion[0][0] - start.position_w_m.x());
    out.y_m.push_back(motion[1][0] - start.position_w_m.y());
    out.z_m.push_back(motion[2][0] - start.position_w_m.z());
    out.speed_m_s.push_back(effort.speed_m_s);
    out.tilt_deg.push_back(core::kRadian_deg * effort.tilt_rad);
  }
  return out;
}

/// A cross at the beginning of the course and at the end of each piece.
plot::Curve crosses(const ref::Trajectory<double>& course, std::span<const companion::CoursePiece> pieces,
                    const ref::Waypoint<double>& start, double half_m) {
  plot::Curve line{.name = "start, and ends of pieces", .color = plot::kOrange, .width = 2.0};
  const double none = std::nan("");
  const auto add = [&](double x_m, double y_m) {
    line.x.insert(line.x.end(), {x_m - half_m, x_m + half_m, none, x_m, x_m, none});
    line.y.insert(line.y.end(), {y_m, y_m, none, y_m - half_m, y_m + half_m, none});
  };
  add(0.0, 0.0);
  for (const companion::CoursePiece& piece : pieces) {
    const ref::Motion ends = course.motion(piece.end, true);
    add(ends[0][0] - start.position_w_m.x(), ends[1][0] - start.position_w_m.y());
  }
  return line;
}

plot::Curve fence(const companion::FlightFile& flight) {
  const auto& [x, y] = std::pair{flight.fence_x_m, flight.fence_y_m};
  return {.name = "fence",
          .x = {x.low, x.high, x.high, x.low, x.low},
          .y = {y.low, y.low, y.high, y.high, y.low},
          .color = plot::kGrey,
          .dashed = true};
}

double fence_size_m(const companion::FlightFile& flight) {
  return std::max(flight.fence_x_m.high - flight.fence_x_m.low, flight.fence_y_m.high - flight.fence_y_m.low);
}

std::string over_time(const Samples& samples, const std::vector<double>& values, const std::string& title, Range shown,
                      std::vector<std::pair<double, std::string>> levels) {
  return plot::svg(plot::Figure{.title = title,
                                .x_label = "time since the beginning [s]",
                                .y_label = "",
                                .lines = {{.name = "", .x = samples.t_s, .y = values}},
                                .levels = std::move(levels),
                                .y_range = shown,
                                .width = kSide,
                                .height = kSide / 2.0});
}

/// The range to show: all values, `low` and `high`, with a margin of a tenth at both ends.
Range shown_of(const std::vector<double>& values, double low, double high) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const Range all{std::min(*least, low), std::max(*most, high)};
  const double air = 0.1 * (all.second - all.first);
  return {all.first - air, all.second + air};
}

void place(std::ostream& out, double x, double y, const std::string& drawing) {
  out << "<g transform=\"translate(" << x << ' ' << y << ")\">\n" << drawing << "</g>\n";
}

}  // namespace

Summary summary_of(const ref::Trajectory<double>& course, std::span<const companion::CoursePiece> pieces,
                   const ref::Waypoint<double>& start) {
  Summary out;
  out.duration_s = core::seconds<double>(course.duration());
  std::array<double, 3> before{};
  companion::for_each_sample(
      course, pieces, [&](const companion::CoursePiece&, core::Duration, const ref::Motion& motion) {
        const companion::MotionMagnitudes effort = companion::magnitudes_of(motion);
        for (const auto member :
             {&companion::MotionMagnitudes::speed_m_s, &companion::MotionMagnitudes::acceleration_m_s2,
              &companion::MotionMagnitudes::tilt_rad, &companion::MotionMagnitudes::climb_m_s,
              &companion::MotionMagnitudes::yaw_rate_rad_s}) {
          out.most.*member = std::max(out.most.*member, effort.*member);
        }
        std::array<double, 3> here{};
        std::array<companion::Range*, 3> ranges{&out.x_m, &out.y_m, &out.z_m};
        for (std::size_t d = 0; d < here.size(); ++d) {
          here[d] = motion[d][0] - start.position_w_m[static_cast<Eigen::Index>(d)];
          *ranges[d] = {std::min(ranges[d]->low, here[d]), std::max(ranges[d]->high, here[d])};
        }
        out.length_m += std::hypot(here[0] - before[0], here[1] - before[1], here[2] - before[2]);
        before = here;
      });
  return out;
}

std::string picture(const std::string& title, const ref::Trajectory<double>& course,
                    std::span<const companion::CoursePiece> pieces, const ref::Waypoint<double>& start,
                    const companion::CourseLimits& limits, const std::optional<companion::FlightFile>& flight) {
  const Samples samples = samples_of(course, start);
  const auto [x_low, x_high] = std::minmax_element(samples.x_m.begin(), samples.x_m.end());
  const auto [y_low, y_high] = std::minmax_element(samples.y_m.begin(), samples.y_m.end());
  const double size_m = std::max({*x_high - *x_low, *y_high - *y_low, 0.1});
  const bool shows_fence = flight && (!flight->fence_x_m.contains(*x_low) || !flight->fence_x_m.contains(*x_high) ||
                                      !flight->fence_y_m.contains(*y_low) || !flight->fence_y_m.contains(*y_high) ||
                                      size_m > kNear * fence_size_m(*flight));
  const double seen_m = shows_fence ? std::max(size_m, fence_size_m(*flight)) : size_m;
  plot::Figure above{
      .title = title,
      .x_label = "x from the start [m]",
      .y_label = "y from the start [m]",
      .lines = {{.name = "", .x = samples.x_m, .y = samples.y_m}, crosses(course, pieces, start, kCross * seen_m)},
      .equal_axes = true,
      .width = kSide,
      .height = 1.5 * kSide};
  Range across{*x_low, *x_high};
  if (shows_fence) {
    above.lines.push_back(fence(*flight));
    across = {std::min(across.first, flight->fence_x_m.low), std::max(across.second, flight->fence_x_m.high)};
  }
  above.x_range = Range{across.first - kAir * seen_m, across.second + kAir * seen_m};
  std::ostringstream out;
  const double width = 2.0 * kSide, height = 1.5 * kSide;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\"" << width
      << "\" height=\"" << height << "\">\n";
  place(out, 0.0, 0.0, plot::svg(above));
  const double limit_deg = core::kRadian_deg * limits.tilt_rad;
  place(out, kSide, 0.0,
        over_time(samples, samples.speed_m_s, "speed [m/s]", shown_of(samples.speed_m_s, 0.0, 0.5), {}));
  place(out, kSide, kSide / 2.0,
        over_time(samples, samples.tilt_deg, "tilt that it needs [deg]", shown_of(samples.tilt_deg, 0.0, limit_deg),
                  {{limit_deg, "limit"}}));
  place(out, kSide, kSide,
        over_time(samples, samples.z_m, "height over the start [m]", shown_of(samples.z_m, -0.25, 0.25), {}));
  out << "</svg>\n";
  return out.str();
}

}  // namespace m100::lab::course
