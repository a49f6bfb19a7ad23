// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/flight_result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "firmware/companion/files/recorded_flight.h"
#include "firmware/companion/replay/replay.h"
#include "firmware/core/maths.h"
#include "host_tests/lab/aliases.h"
#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/flight/tracking.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::evening {
namespace {

constexpr std::string_view kTrackingMap = R"(time = "tick.timestamp"
[signals]
stick_roll = { column = "tick.sticks[0]", offset = -1024 }
stick_pitch = { column = "tick.sticks[1]", offset = -1024 }
attitude_roll = "tick.imu_attitude[0]"
attitude_pitch = "tick.imu_attitude[1]"
[extra]
age = "tick.pose_age"
ref_yaw = "tick.ref_yaw"
yaw = "tick.pose_yaw"
)";

/// Root mean square of the pose's heading minus the reference at the pose's time of capture.
double heading_error_deg(const Folder& folder, const std::string& name) {
  constexpr double kMaxAge_s = 0.5;
  const std::pair<double, double> flown = nominal(result_of(folder, name + ".json"));
  const logs::FlightLog flight = tracked(folder, name + ".ulg");
  double sum_rad2 = 0.0;
  double count = 0.0;
  const auto first = static_cast<std::size_t>(kMaxAge_s / flight.period_s) + 1;
  for (std::size_t k = std::max(first, flight.index_of(flown.first + kSettled_s)); k < flight.index_of(flown.second);
       ++k) {
    const auto ago = static_cast<std::size_t>(std::clamp(flight.extra.at("age")[k], 0.0, kMaxAge_s) / flight.period_s);
    const double heading_rad = flight.extra.at("yaw")[k] - flight.extra.at("ref_yaw")[k - ago];
    sum_rad2 += std::pow(std::remainder(heading_rad, 2.0 * std::numbers::pi), 2);
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum_rad2 / count) * core::kRadian_deg : 0.0;
}

/// The name of the log note that holds a file which the flight read; empty: none does.
std::string note_of(const std::string& file) {
  if (file == "flight.toml") {
    return companion::kFlightNote;
  }
  if (file == "course.txt") {
    return companion::kCourseNote;
  }
  return file.ends_with(".toml") ? companion::kVehicleNote : "";
}

}  // namespace

Json result_of(const Folder& folder, const std::string& result) {
  const Json read = Json::parse(whole_file(folder.file(result)));
  return read.is_object() ? with_current_names(read) : Json::object();
}

std::pair<double, double> nominal(const Json& result) {
  std::pair<double, double> out{0.0, 0.0};
  for (const Json& step : result.value("failsafe", Json::array())) {
    if (step.value("to", "") == "nominal" && out.first == 0.0) {
      out.first = step.value("t_s", 0.0);
    } else if (step.value("from", "") == "nominal") {
      out.second = step.value("t_s", 0.0);
    }
  }
  return out;
}

std::pair<double, double> moved(const Folder& folder, const std::string& name, ctl::ExcitedStick stick) {
  constexpr double kAfter_s = 1.0;
  if (!folder.has(name + ".json") || !result_of(folder, name + ".json").contains("excitation")) {
    return {};
  }
  const std::unique_ptr<logs::RawLog> log = logs::open_log(folder.file(name + ".ulg"));
  const logs::RawColumn state = log->column("excitation.state", "");
  const logs::RawColumn axis = log->column("excitation.axis", "");
  std::pair<double, double> range;
  for (std::size_t i = 0; i < std::min(state.values.size(), axis.values.size()); ++i) {
    if (state.values[i] == static_cast<double>(ctl::Excitation<double>::State::kMoving) &&
        axis.values[i] == static_cast<double>(stick)) {
      range = {range.second > 0.0 ? range.first : state.time_s[i], state.time_s[i] + kAfter_s};
    }
  }
  return range;
}

logs::FlightLog tracked(const Folder& folder, const std::string& log) {
  return logs::load(*logs::open_log(folder.file(log)), logs::parse_column_map(kTrackingMap, "(heading and tilt)"));
}

bool record_errors(Folder& folder, const std::string& name) {
  const std::vector<flight::TrackingError> errors =
      flight::tracking_errors(flight::read_series(folder.file(name + ".ulg"), nullptr));
  if (errors.empty()) {
    return false;
  }
  std::array<double, 3> mean_m2{};
  for (const flight::TrackingError& one : errors) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mean_m2[axis] += one.error_m[axis] * one.error_m[axis] / static_cast<double>(errors.size());
    }
  }
  const auto& [x_m2, y_m2, z_m2] = mean_m2;
  folder.set_number("pose_m." + name, std::sqrt(x_m2 + y_m2 + z_m2));
  folder.set_number("horizontal_m." + name, std::sqrt(x_m2 + y_m2));
  folder.set_number("x_m." + name, std::sqrt(x_m2));
  folder.set_number("y_m." + name, std::sqrt(y_m2));
  folder.set_number("height_m." + name, std::sqrt(z_m2));
  folder.set_number("heading_deg." + name, heading_error_deg(folder, name));
  return true;
}

std::string differing_input(const Folder& folder, const std::string& name, const std::vector<std::string>& reads) {
  const std::string log = name + ".ulg";
  if (reads.empty() || !folder.has(log)) {
    return "";
  }
  std::map<std::string, std::string> notes;
  try {
    notes = companion::read_flight(folder.file(log)).notes;
  } catch (const companion::FlightLogError& wrong) {
    return wrong.what();
  }
  const auto other = std::find_if(reads.begin(), reads.end(), [&](const std::string& file) {
    const std::string note = note_of(file);
    return !note.empty() && notes[note] != whole_file(folder.file(file));
  });
  return other == reads.end() ? "" : log + ": was flown with a different " + *other + " than the folder holds";
}

}  // namespace m100::lab::evening
