// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/page.h"

#include <iomanip>
#include <limits>
#include <vector>

#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"
#include "host_tests/lab/printable.h"

namespace m100::lab::campaign {
namespace {

std::string number_of(const Json& value) { return value.is_null() ? "---" : plot::number(value.get<double>()); }

std::string of(const Json& some, const Json& all) {
  return std::to_string(some.get<std::size_t>()) + " of " + std::to_string(all.get<std::size_t>());
}

/// The header row, and one row for each world that has flights.
std::vector<std::vector<std::string>> rows_of(const Json& report) {
  std::vector<std::vector<std::string>> rows{{"world", "stayed", "coasted", "released", "fence", "oscillating",
                                              "worst tilt [deg]", "pose median [m]", "95 % [m]", "max [m]", "NEES",
                                              "NIS"}};
  for (const auto& [name, world] : report.at("worlds").items()) {
    if (world.at("flights") == 0) {
      continue;
    }
    const Json& pose = world.at("pose_rms_m");
    rows.push_back({name, of(world.at("stayed"), world.at("flights")), world.at("coasted").dump(),
                    world.at("released").dump(), world.at("fence_breaches").dump(), world.at("oscillating").dump(),
                    number_of(world.at("worst_tilt_deg")), number_of(pose.at("median")), number_of(pose.at("p95")),
                    number_of(pose.at("max")), number_of(world.at("nees")), number_of(world.at("nis"))});
  }
  return rows;
}

/// A heat map of one number for each task in each world; the cell of a task that was not flown is empty.
template <typename Value, typename Words>
plot::HeatMap map_of(const Json& report, const std::string& title, double good, double bad, const Value& value,
                     const Words& words) {
  plot::HeatMap map{.title = title, .good = good, .bad = bad};
  for (const Json& task : report.at("campaign").at("tasks")) {
    map.columns.push_back(task.get<std::string>());
  }
  for (const auto& [name, world] : report.at("worlds").items()) {
    map.rows.push_back(name);
    map.values.emplace_back();
    map.words.emplace_back();
    for (const std::string& task : map.columns) {
      const bool flown = world.contains("tasks") && world.at("tasks").contains(task);
      map.values.back().push_back(flown ? value(world.at("tasks").at(task)) : std::numeric_limits<double>::quiet_NaN());
      map.words.back().push_back(flown ? words(world.at("tasks").at(task)) : std::string());
    }
  }
  return map;
}

std::string summary(const Json& report) {
  std::size_t flights = 0;
  std::size_t stayed = 0;
  std::size_t oscillating = 0;
  for (const auto& [name, world] : report.at("worlds").items()) {
    flights += world.at("flights").get<std::size_t>();
    stayed += world.value("stayed", std::size_t{0});
    oscillating += world.value("oscillating", std::size_t{0});
  }
  return std::to_string(stayed) + " of " + std::to_string(flights) + " flights stayed, " + std::to_string(oscillating) +
         " oscillate.";
}

}  // namespace

void print_table(std::ostream& out, const Json& report) {
  const std::vector<std::vector<std::string>> rows = rows_of(report);
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      widths[c] = std::max(widths[c], row[c].size());
    }
  }
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      out << (c > 0 ? "  " : "") << (c == 0 ? std::left : std::right) << std::setw(static_cast<int>(widths[c]))
          << printable(row[c]);
    }
    out << "\n";
  }
  for (const auto& [name, world] : report.at("worlds").items()) {
    for (const Json& failure : world.value("failures", Json::array())) {
      out << printable(name) << ", " << printable(failure.at("task").get<std::string>()) << ", seed "
          << failure.at("seed").dump() << ", at " << plot::number(failure.at("at_s").get<double>())
          << " s: " << printable(failure.at("why").get<std::string>()) << "\n  "
          << printable(failure.at("command").get<std::string>()) << "\n";
    }
  }
  out << summary(report) << "\n";
}

void write_page(const std::string& folder, const Json& report,
                const std::vector<std::pair<std::string, std::string>>& flights) {
  plot::Page page("Campaign");
  page.paragraph("Asked: does the flight program keep each task under control in each of these worlds?");
  page.paragraph("Every number here is simulated: the flight program over the emulated wire, autopilot and aircraft.");
  const std::string words = summary(report);
  std::size_t failures = 0;
  for (const auto& [name, world] : report.at("worlds").items()) {
    failures += world.value("failures", Json::array()).size();
  }
  page.verdict(words, failures == 0 ? "good" : "bad");
  page.table(rows_of(report));
  page.paragraph(
      "Stayed: never below the state coast and always inside the fence until the task was over. NEES and NIS: the "
      "estimator's squared errors and innovations, normalised by its covariance and divided by their degrees of "
      "freedom; 1 is right, above 1 the covariance is too small.");
  const auto share = [](const Json& task) {
    return task.at("stayed").get<double>() / task.at("flights").get<double>();
  };
  const auto counted = [](const Json& task) { return of(task.at("stayed"), task.at("flights")); };
  page.figure(map_of(report, "Flights that stay", 1.0, 0.0, share, counted),
              "Never below the state coast and always inside the fence until the task was over.");
  const auto or_nothing = [](const Json& value) {
    return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
  };
  const auto pose_m = [&](const Json& task) { return or_nothing(task.at("pose_rms_m").at("p95")); };
  const auto pose_words = [&](const Json& task) { return number_of(task.at("pose_rms_m").at("p95")); };
  page.figure(map_of(report, "Pose error, root mean square, 95 % of the flights [m]", 0.02, 1.0, pose_m, pose_words),
              "Distance from the reference; the length of a step itself is included.");
  const auto tilt_deg = [&](const Json& task) { return or_nothing(task.at("tilt_rms_deg")); };
  const auto tilt_words = [&](const Json& task) { return number_of(task.at("tilt_rms_deg")); };
  page.figure(
      map_of(report, "Tilt, root mean square [deg]", 0.5, 10.0, tilt_deg, tilt_words),
      "Tilt of the thrust axis, including the lean against the wind. The table counts the flights that oscillate: each "
      "is compared with the same task in the nominal world with the same air.");
  if (failures > 0) {
    page.heading("Flights that did not stay");
    std::vector<std::vector<std::string>> rows{{"world", "task", "seed", "at [s]", "why", "command that repeats it"}};
    for (const auto& [name, world] : report.at("worlds").items()) {
      for (const Json& failure : world.value("failures", Json::array())) {
        rows.push_back({name, failure.at("task").get<std::string>(), failure.at("seed").dump(),
                        number_of(failure.at("at_s")), failure.at("why").get<std::string>(),
                        failure.at("command").get<std::string>()});
      }
    }
    page.table(rows);
  }
  if (!flights.empty()) {
    page.heading("The worst flight of each world");
    page.links(flights);
  }
  page.write(folder + "/campaign.html");
}

}  // namespace m100::lab::campaign
