// SPDX-License-Identifier: BSD-3-Clause
// m100-lab course: draws a course before a flight, and reports its demands and whether it can be flown.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/core/maths.h"
#include "host_tests/lab/course/picture.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct Options {
  std::vector<std::string> courses;
  std::string flight, out, json;
};

struct Drawn {
  std::string file, why_not;  ///< why_not is empty: the course can be flown
  course::Summary summary;
};

std::string stem(const std::string& file) { return std::filesystem::path(file).stem().string(); }

/// Why the course cannot be flown, inside the fence of a flight file too; empty: it can. It is checked from `start`.
std::string refusal(const ref::Trajectory<double>& laid, const std::vector<companion::CoursePiece>& pieces,
                    const ref::Waypoint<double>& start, const companion::CourseLimits& limits,
                    const std::optional<companion::FlightFile>& flight, const std::string& file) {
  try {
    companion::validate_course(laid, pieces, start, limits, file);
    if (flight) {
      companion::validate_inside_fence(*flight, start, laid, pieces, file);
    }
  } catch (const companion::CourseError& no) {
    return no.what();
  } catch (const companion::FileError& no) {
    return no.what();
  }
  return {};
}

Drawn draw(const std::string& file, const Options& options, const std::optional<companion::FlightFile>& flight) {
  const std::string text = whole_file(file);
  const auto laid = std::make_unique<ref::Trajectory<double>>();
  ref::Waypoint<double> start;
  std::vector<companion::CoursePiece> pieces = companion::parse_course(text, start, *laid, file);
  if (pieces.empty()) {
    throw InputError(file, 0, "", "contains no piece");
  }
  Drawn out{.file = file, .why_not = {}, .summary = course::summary_of(*laid, pieces, start)};
  if (flight) {  // the lowest start from which the course stays above the floor
    start.position_w_m.z() = flight->fence_z_m.low - out.summary.z_m.low;
    pieces = companion::parse_course(text, start, *laid, file);
  }
  const companion::CourseLimits limits = flight ? companion::course_limits_of(*flight) : companion::CourseLimits{};
  out.why_not = refusal(*laid, pieces, start, limits, flight, file);
  if (!options.out.empty()) {
    const std::string name = printable(stem(file), 40) + (out.why_not.empty() ? "" : ": cannot be flown");
    write_whole_file(options.out + "/" + stem(file) + ".svg",
                     course::picture(name, *laid, pieces, start, limits, flight), "--out");
  }
  return out;
}

Json to_json(const Drawn& drawn) {
  const course::Summary& s = drawn.summary;
  const auto range = [](const companion::Range& r) { return Json{r.low, r.high}; };
  return {{"course", drawn.file},
          {"flyable", drawn.why_not.empty()},
          {"why_not", drawn.why_not},
          {"duration_s", s.duration_s},
          {"length_m", s.length_m},
          {"speed_m_s", s.most.speed_m_s},
          {"acceleration_m_s2", s.most.acceleration_m_s2},
          {"tilt_deg", core::kRadian_deg * s.most.tilt_rad},
          {"climb_m_s", s.most.climb_m_s},
          {"yaw_rate_deg_s", core::kRadian_deg * s.most.yaw_rate_rad_s},
          {"x_m", range(s.x_m)},
          {"y_m", range(s.y_m)},
          {"z_m", range(s.z_m)}};
}

void say(const Drawn& drawn) {
  const course::Summary& s = drawn.summary;
  std::cout << printable(drawn.file)
            << printed(": %.1f s, %.1f m, at most %.2f m/s, %.2f m/s^2, %.1f deg of tilt, %.0f deg/s of yaw\n",
                       s.duration_s, s.length_m, s.most.speed_m_s, s.most.acceleration_m_s2,
                       core::kRadian_deg * s.most.tilt_rad, core::kRadian_deg * s.most.yaw_rate_rad_s);
  if (!drawn.why_not.empty()) {
    std::cout << "  cannot be flown: " << printable(drawn.why_not) << "\n";
  }
}

void check_files(const Options& options) {
  companion::FileUse use;
  use.reads("courses", options.courses).reads("--flight", options.flight).writes("--json", options.json);
  std::set<std::string> names;
  for (const std::string& file : options.courses) {
    if (!names.insert(stem(file)).second) {
      throw InputError(file, 0, "", "two courses of this name would be drawn into the same picture");
    }
    if (!options.out.empty()) {
      use.fills("--out", options.out, stem(file) + ".svg");
    }
  }
  use.check();
}

void run(const Options& options) {
  check_files(options);
  std::optional<companion::FlightFile> flight;
  if (!options.flight.empty()) {
    flight = companion::parse_flight(whole_file(options.flight), options.flight);
  }
  if (!options.out.empty()) {
    std::filesystem::create_directories(options.out);
  }
  Json all = Json::array();
  bool flyable = true;
  for (const std::string& file : options.courses) {
    const Drawn drawn = draw(file, options, flight);
    say(drawn);
    all.push_back(to_json(drawn));
    flyable = flyable && drawn.why_not.empty();
  }
  write_json(options.json, Json{{"courses", all}});
  if (!flyable) {
    throw companion::AnswerIsNo();
  }
}

}  // namespace

void add_course(companion::CommandLine& lab) {
  const auto [app, options] =
      lab.add_subcommand<Options>("course", "draw courses, report their demands and whether they can be flown", run);
  app.add_option("courses", options->courses, "course files, as m100 fly takes them").required();
  app.add_option("--flight", options->flight, "flight file (TOML): its fence and course limits are checked too");
  app.add_option("--out", options->out, "folder for a picture of each course (NAME.svg)");
  app.add_option("--json", options->json, "the demands of each course, as JSON");
  app.footer(companion::course_help() + "\nExit code 1: one of the courses cannot be flown; it is still drawn.");
}

}  // namespace m100::lab
