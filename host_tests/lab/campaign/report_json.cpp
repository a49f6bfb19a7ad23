// SPDX-License-Identifier: BSD-3-Clause
// The result of a campaign as JSON. Summaries are computed only from the JSON of the single flights, so that a merged
// report cannot differ from the report of one process.
#include "host_tests/lab/campaign/report_json.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host_tests/lab/aliases.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::campaign {
namespace {

/// The quantile, interpolated linearly between two ranks (the usual definition, type 7).
double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0.0;
  }
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

/// Median, 95 % quantile and maximum; null if no flight has a value.
Json spread(const std::vector<double>& values) {
  if (values.empty()) {
    return {{"median", nullptr}, {"p95", nullptr}, {"max", nullptr}};
  }
  return {{"median", quantile(values, 0.5)}, {"p95", quantile(values, 0.95)}, {"max", quantile(values, 1.0)}};
}

Json json_of(const Campaign& campaign, const Flown& flown) {
  const Outcome& out = flown.outcome;
  return {{"number", flown.number},
          {"world", campaign.world_of(flown.number).name},
          {"task", campaign.task_of(flown.number).name},
          {"seed", campaign.seed_of(flown.number)},
          {"scored", out.scored},
          {"stayed", out.stayed},
          {"coasted", out.coasted},
          {"released", out.released},
          {"fence_breach", out.breached},
          {"oscillating", out.oscillated},
          {"limit_cycle_detected_s", out.limit_cycle_detected_s},
          {"contradicted", out.contradicted},
          {"left_model", out.model_mismatch},
          {"refused_poses", out.refused_poses},
          {"latency_error_s", out.latency_error_s},
          {"latency_sigma_s", out.latency_sigma_s},
          {"handed_over_m_s", out.handed_over_m_s},
          {"worst_tilt_deg", out.worst_tilt_deg},
          {"pose_rms_m", out.pose_rms_m},
          {"tilt_rms_deg", out.tilt_rms_deg},
          {"command_deg_s", out.command_deg_s},
          {"nees_sum", out.nees_sum},
          {"nees_count", out.nees_count},
          {"nis_sum", out.nis_sum},
          {"nis_count", out.nis_count},
          {"at_s", out.failed_at_s},
          {"why", out.why}};
}

/// Counts and sums over some flights.
struct Sums {
  std::size_t flights = 0;
  std::map<std::string, std::size_t> counts;
  std::map<std::string, double> sums;
  double worst_tilt_deg = 0.0;
  double tilt_square = 0.0;
  std::vector<double> pose_rms_m;

  void add(const Json& flight) {
    ++flights;
    for (const char* const key : {"stayed", "coasted", "released", "fence_breach", "oscillating"}) {
      counts[key] += flight.at(key).get<bool>() ? 1U : 0U;
    }
    for (const char* const key : {"command_deg_s", "nees_sum", "nees_count", "nis_sum", "nis_count"}) {
      sums[key] += flight.at(key).get<double>();
    }
    worst_tilt_deg = std::max(worst_tilt_deg, flight.at("worst_tilt_deg").get<double>());
    if (!flight.value("scored", true)) {
      return;  // it never flew its course: its error is unknown, not zero
    }
    const double tilt_deg = flight.at("tilt_rms_deg").get<double>();
    tilt_square += tilt_deg * tilt_deg;
    pose_rms_m.push_back(flight.at("pose_rms_m").get<double>());
  }
  /// The mean divided by the degrees of freedom; null if nothing was counted.
  Json mean(const char* sum, const char* count, double freedom) const {
    const double number = sums.at(count);
    return number > 0.0 ? Json(sums.at(sum) / number / freedom) : Json();
  }
};

Json task_json(const Sums& sums) {
  const auto scored = static_cast<double>(sums.pose_rms_m.size());
  return {{"flights", sums.flights},
          {"stayed", sums.counts.at("stayed")},
          {"oscillating", sums.counts.at("oscillating")},
          {"worst_tilt_deg", sums.worst_tilt_deg},
          {"pose_rms_m", spread(sums.pose_rms_m)},
          {"tilt_rms_deg", scored > 0.0 ? Json(std::sqrt(sums.tilt_square / scored)) : Json()},
          {"command_deg_s", scored > 0.0 ? Json(sums.sums.at("command_deg_s") / scored) : Json()}};
}

/// Quotes a word so that a shell passes it on unchanged.
std::string quoted(const std::string& word) {
  const bool plain = word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+") ==
                         std::string::npos &&
                     !word.empty();
  if (plain) {
    return word;
  }
  std::string out = "'";
  for (const char letter : word) {
    out += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  }
  return out + "'";
}

Json failure(const Json& settings, const Json& world, const Json& flight) {
  const std::string seed = std::to_string(flight.at("seed").get<std::uint64_t>());
  const std::string task = flight.at("task").get<std::string>();
  std::string command = "m100-lab campaign " + quoted(world.at("path").get<std::string>()) + " --tasks " + task +
                        " --flights 1 --seed " + seed;
  for (const Json& option : settings.at("options")) {
    command += " " + quoted(option.get<std::string>());
  }
  return {{"task", task},
          {"seed", flight.at("seed")},
          {"at_s", flight.at("at_s")},
          {"why", flight.at("why")},
          {"command", command}};
}

Json world_json(const Json& settings, const Json& world, const Json& flown) {
  Sums all;
  std::map<std::string, Sums> by_task;
  Json failures = Json::array();
  for (const Json& flight : flown) {
    if (flight.at("world") != world.at("name")) {
      continue;
    }
    all.add(flight);
    by_task[flight.at("task").get<std::string>()].add(flight);
    if (!flight.at("stayed").get<bool>()) {
      failures.push_back(failure(settings, world, flight));
    }
  }
  if (all.flights == 0) {
    return {{"flights", 0}};
  }
  Json tasks = Json::object();
  for (const Json& name : settings.at("tasks")) {
    const auto found = by_task.find(name.get<std::string>());
    if (found != by_task.end()) {
      tasks[found->first] = task_json(found->second);
    }
  }
  return {{"flights", all.flights},
          {"stayed", all.counts.at("stayed")},
          {"coasted", all.counts.at("coasted")},
          {"released", all.counts.at("released")},
          {"fence_breaches", all.counts.at("fence_breach")},
          {"oscillating", all.counts.at("oscillating")},
          {"worst_tilt_deg", all.worst_tilt_deg},
          {"pose_rms_m", spread(all.pose_rms_m)},
          {"nees", all.mean("nees_sum", "nees_count", 4.0)},
          {"nis", all.mean("nis_sum", "nis_count", 2.0)},
          {"tasks", tasks},
          {"failures", failures}};
}

Json assembled(const Json& settings, const Json& part, const Json& flown) {
  Json report;
  report["simulated"] = true;
  Json& worlds = report["worlds"] = Json::object();
  for (const Json& world : settings.at("worlds")) {
    worlds[world.at("name").get<std::string>()] = world_json(settings, world, flown);
  }
  report["campaign"] = settings;
  if (!part.is_null()) {
    report["part"] = part;
  }
  report["flown"] = flown;
  return report;
}

Json settings_json(const Campaign& campaign) {
  Json worlds = Json::array();
  for (const World& world : campaign.worlds) {
    worlds.push_back({{"name", world.name}, {"path", world.path}, {"sha256", world.digest}});
  }
  Json tasks = Json::array();
  for (const Task& task : campaign.tasks) {
    tasks.push_back(task.name);
  }
  const auto digest = core::hex(campaign.settings.plan.vehicle.digest);
  return {{"worlds", worlds},
          {"tasks", tasks},
          {"first_seed", campaign.first_seed},
          {"flights", campaign.flights},
          {"vehicle_sha256", std::string(digest.begin(), digest.end())},
          {"options", campaign.options}};
}

/// Checks each part alone for what the table and the page will read, so that an error names the file.
void require_whole(const Json& part, const std::string& path) {
  const auto require = [&path](bool is_so, const char* what) {
    if (!is_so) {
      throw InputError(path, 0, what, "is missing or wrong: this is not a report of m100-lab campaign");
    }
  };
  const Json& settings = part.at("campaign");
  require(settings.at("flights").is_number_unsigned(), "flights");
  for (const Json& flight : part.at("flown")) {
    require(flight.at("number").is_number_unsigned() && flight.at("seed").is_number_unsigned(), "number");
    require(flight.at("at_s").is_number() && flight.at("why").is_string(), "why");
  }
  std::size_t flights = 0;
  const Json report = assembled(settings, Json(), part.at("flown"));
  for (const Json& world : report.at("worlds")) {
    for (const Json& task : world.value("tasks", Json::object())) {
      flights += task.at("flights").get<std::size_t>();
    }
  }
  require(flights == part.at("flown").size(), "flown");  // each belongs to a world and a task of the campaign
}

Json read_part(const std::string& path) {
  Json part = with_current_names(Json::parse(whole_file(path)));
  if (!part.is_object() || !part.contains("campaign") || !part.contains("flown") || !part.at("flown").is_array()) {
    throw InputError(path, 0, "", "is not a report of m100-lab campaign");
  }
  of_json(path, "is not a report of m100-lab campaign", [&] { require_whole(part, path); });
  return part;
}

}  // namespace

Json to_json(const Campaign& campaign, const Share& share, const std::vector<Flown>& flown) {
  Json flights = Json::array();
  for (const Flown& one : flown) {
    flights.push_back(json_of(campaign, one));
  }
  const Json part = share.parts > 1 ? Json(std::to_string(share.part) + "/" + std::to_string(share.parts)) : Json();
  return assembled(settings_json(campaign), part, flights);
}

Json merged(const std::vector<std::string>& paths) {
  Json settings;
  std::map<std::size_t, Json> by_number;
  for (const std::string& path : paths) {
    const Json part = read_part(path);
    if (!settings.is_null() && settings != part.at("campaign")) {
      throw InputError(path, 0, "campaign",
                       "differs from that of " + paths.front() + ": the files are not parts of one campaign");
    }
    settings = part.at("campaign");
    for (const Json& flight : part.at("flown")) {
      const auto number = flight.at("number").get<std::size_t>();
      if (!by_number.emplace(number, flight).second) {
        throw InputError(path, 0, "flown", "flight " + std::to_string(number) + " is in two parts");
      }
    }
  }
  const std::size_t size =
      settings.at("worlds").size() * settings.at("tasks").size() * settings.at("flights").get<std::size_t>();
  if (by_number.size() != size) {
    throw InputError(
        paths.front(), 0, "flown",
        std::to_string(by_number.size()) + " of " + std::to_string(size) + " flights were found: a part is missing");
  }
  Json flown = Json::array();
  for (const auto& [number, flight] : by_number) {
    flown.push_back(flight);
  }
  return assembled(settings, Json(), flown);
}

bool all_stayed(const Json& report) {
  const Json& flown = report.at("flown");
  return std::all_of(flown.begin(), flown.end(), [](const Json& flight) { return flight.at("stayed").get<bool>(); });
}

}  // namespace m100::lab::campaign
