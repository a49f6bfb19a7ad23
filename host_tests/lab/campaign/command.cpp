// SPDX-License-Identifier: BSD-3-Clause
// m100-lab campaign: flies worlds x tasks x seeds on all cores, and joins the parts that other machines flew.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>
#include <span>
#include <thread>
#include <utility>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/recorded_flight.h"
#include "firmware/companion/mode_option.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/body_options.h"
#include "host_tests/lab/campaign/campaign.h"
#include "host_tests/lab/campaign/page.h"
#include "host_tests/lab/campaign/report_json.h"
#include "host_tests/lab/flight/page.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"
#include "host_tests/sim/body/body_plant.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab {
namespace campaign {
namespace {

struct Options {
  std::vector<std::string> worlds;
  std::vector<std::string> merge;
  std::size_t flights = 10;
  std::uint64_t seed = 1;
  std::string vehicle;
  std::string plant_from;
  std::string tasks = "hover,step_1m,step_3m,step_6m,square,trajectory";
  std::string law = "mpc";
  std::string mode = "field";
  std::string channel = "virtual_rc";
  double rate_hz = 0.0;
  std::size_t jobs = 0;
  std::string split;
  std::string json;
  std::string report;
  sim::BodyChoice body;
};

std::string read_text(const std::string& path) { return whole_file(path, companion::kMaxTextBytes); }

std::vector<World> read_worlds(const Options& options) {
  std::vector<World> worlds;
  std::set<std::string> names;
  for (const std::string& path : options.worlds) {
    const std::string text = read_text(path);
    const auto digest = core::hex(core::sha256(std::as_bytes(std::span(text.data(), text.size()))));
    worlds.push_back({.name = std::filesystem::path(path).stem().string(),
                      .path = path,
                      .digest = std::string(digest.begin(), digest.end()),
                      .plant = sim::parse_plant(options.body, text, path, options.plant_from)});
    if (!names.insert(worlds.back().name).second) {
      throw InputError(path, 0, "", "two worlds have the name " + worlds.back().name);
    }
  }
  return worlds;
}

Share share_of(const std::string& words) {
  if (words.empty()) {
    return {};
  }
  const std::size_t slash = words.find('/');
  const bool digits = slash != std::string::npos && slash > 0 && slash + 1 < words.size() && words.size() < 16 &&
                      words.find_first_not_of("0123456789") == slash &&
                      words.find_first_not_of("0123456789", slash + 1) == std::string::npos;
  if (digits) {
    const Share share{.part = std::stoul(words.substr(0, slash)), .parts = std::stoul(words.substr(slash + 1))};
    if (share.part >= 1 && share.part <= share.parts) {
      return share;
    }
  }
  throw InputError("--split", 0, words, "must be I/N with I from 1 to N, such as 3/8");
}

Campaign campaign_of(const Options& options) {
  Campaign out;
  out.worlds = read_worlds(options);
  out.tasks = tasks_of(options.tasks);
  out.first_seed = options.seed;
  out.flights = options.flights;
  out.settings.plan.vehicle = companion::in_mode(
      options.vehicle.empty() ? companion::as_file(mpc::generated::kVehicle) : companion::load_vehicle(options.vehicle),
      mode_of(options.mode));
  out.settings.plan.channel = options.channel == "movement" ? link::Channel::kMovement : link::Channel::kVirtualRc;
  out.settings.plan.rate_hz = options.rate_hz;
  out.settings.plan.law = law_of(options.law);
  out.settings.paper_law = options.law == kPaperLaw;
  out.settings.body = options.body;
  if (!link::command_period({.channel = out.settings.plan.channel, .rate_hz = options.rate_hz})) {
    throw InputError("--rate", 0, "", "outside the window of the channel: virtual_rc 5 to 25 Hz, movement 1 to 50 Hz");
  }
  const auto repeat = [&out](const char* option, const std::string& value, bool wanted) {
    if (wanted) {
      out.options.insert(out.options.end(), {option, value});
    }
  };
  repeat("--vehicle", options.vehicle, !options.vehicle.empty());
  repeat("--plant-from", options.plant_from, !options.plant_from.empty());
  repeat("--law", options.law, options.law != "mpc");
  repeat("--mode", options.mode, options.mode != "field");
  repeat("--channel", options.channel, options.channel != "virtual_rc");
  repeat("--rate", printed("%g", options.rate_hz), options.rate_hz > 0.0);
  repeat("--body", options.body.body, options.body.body != "identified");
  repeat("--body-command", options.body.command, !options.body.command.empty());
  return out;
}

/// The flight of a world with the largest pose error, among those that did not stay if there are any; null: no flight.
const Json* worst_flight(const Json& report, const std::string& world) {
  const Json* worst = nullptr;
  for (const Json& flight : report.at("flown")) {
    const auto rank = [](const Json& one) {
      return std::pair(!one.at("stayed").get<bool>(), one.at("pose_rms_m").get<double>());
    };
    if (flight.at("world") == world && (worst == nullptr || rank(flight) > rank(*worst))) {
      worst = &flight;
    }
  }
  return worst;
}

/// Flies the worst flight of each world again and writes its page into the folder. @returns each page's title and file
std::vector<std::pair<std::string, std::string>> write_flights(const std::string& folder, const Campaign& campaign,
                                                               const Json& report) {
  std::vector<std::pair<std::string, std::string>> pages;
  sim::BodyJob body(campaign.settings.body);
  for (const World& world : campaign.worlds) {
    const Json* const shown = worst_flight(report, world.name);
    if (shown == nullptr) {
      continue;
    }
    const std::string task_name = shown->at("task").get<std::string>();
    const std::uint64_t seed = shown->at("seed").get<std::uint64_t>();
    const auto task = std::find_if(campaign.tasks.begin(), campaign.tasks.end(),
                                   [&](const Task& one) { return one.name == task_name; });
    std::string log =
        log_of(world.plant, *task, seed, campaign.settings, campaign.settings.body.is_identified() ? nullptr : &body);
    if (log.empty()) {
      continue;
    }
    const std::string name = world.name + "_" + task_name + "_" + std::to_string(seed);
    const std::string words = world.name + ", " + task_name + ", seed " + std::to_string(seed) +
                              (shown->at("stayed").get<bool>() ? "" : ": " + shown->at("why").get<std::string>());
    pages.emplace_back(words, "flight_" + name + ".html");
    flight::flight_page({flight::series_of(companion::parse_flight_log(std::move(log), name), name, nullptr)},
                        "Flight: " + words, "Simulated, in the world " + world.path + ".")
        .write(folder + "/" + pages.back().second);
  }
  return pages;
}

Json flown(const Options& options, const Campaign& campaign) {
  const Share share = share_of(options.split);
  const bool one_program = options.body.body != "identified";  // such a program flies one aircraft at a time
  const std::size_t jobs = options.jobs > 0 ? options.jobs
                           : one_program    ? 1U
                                            : std::max(1U, std::thread::hardware_concurrency());
  if (one_program && jobs > 1) {
    throw InputError("--jobs", 0, "", "one physics program flies one job; --body-command starts one for each job");
  }
  const std::size_t mine = (campaign.size() + share.parts - share.part) / share.parts;
  std::size_t printed = 0;
  const auto progress = [&](std::size_t done, std::size_t failed) {
    constexpr std::size_t kLines = 20;
    if (done * kLines / mine > printed * kLines / mine || done == mine) {
      std::cerr << done << " of " << mine << " flights, " << failed << " did not stay\n";
    }
    printed = done;
  };
  return to_json(campaign, share, fly(campaign, share, jobs, progress));
}

void run(const Options& options) {
  options.body.check();
  if (options.worlds.empty() == options.merge.empty()) {
    throw InputError("campaign", 0, "", "give the worlds to fly (plant files), or --merge with the parts to join");
  }
  companion::FileUse()
      .reads("--merge", options.merge)
      .reads("worlds", options.worlds)
      .reads("--vehicle", options.vehicle)
      .reads("--plant-from", options.plant_from)
      .writes("--json", options.json)
      .fills("--report", options.report, "campaign.html")
      .check();
  const Campaign campaign = options.merge.empty() ? campaign_of(options) : Campaign{};
  const Json report = options.merge.empty() ? flown(options, campaign) : merged(options.merge);
  print_table(std::cout, report);
  write_json(options.json, report);
  if (!options.report.empty()) {
    write_page(options.report, report, write_flights(options.report, campaign, report));
    std::cout << "wrote " << printable(options.report) << "/campaign.html\n";
  }
  if (!all_stayed(report)) {
    throw companion::AnswerIsNo();
  }
}

}  // namespace
}  // namespace campaign

void add_campaign(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<campaign::Options>(
      "campaign", "fly many simulated flights in many worlds, and report which of them stay", campaign::run);
  command.footer(
      "Exit code 0: every flight stayed inside its fence and never went below the state coast; 1: at least one did "
      "not.");
  command.add_option("worlds", options->worlds, "plant files (TOML), each a world");
  command.add_option("--flights", options->flights, "flights of each task in each world, each with the next seed")
      .in_range(1, 100000);
  command.add_option("--seed", options->seed, "first seed").whole_number();
  command.add_option("--vehicle", options->vehicle,
                     "vehicle file that the controller uses (TOML); default: the project's");
  command.add_option("--plant-from", options->plant_from,
                     "vehicle file that gives the worlds their axes, drag and thrust instead of the measured ones");
  command.add_option("--tasks", options->tasks, "tasks to fly, separated by commas");
  command
      .add_option("--law", options->law,
                  "control law; lqr: the clipped baseline; paper: the law and configuration of the paper's authors")
      .one_of({"mpc", "lqr", "paper"});
  companion::add_mode_option(command, options->mode, "tuning");
  command.add_option("--channel", options->channel, "how commands reach the autopilot")
      .one_of({"virtual_rc", "movement"});
  command.add_option("--rate", options->rate_hz, "commands per second [Hz]; default: the channel's highest");
  add_body_options(command, options->body);
  command.add_option("--jobs", options->jobs, "flights at the same time; 0: one per core").in_range(0, 4096);
  command.add_option("--split", options->split, "I/N: fly only part I of N, to be joined by --merge");
  command.add_option("--merge", options->merge, "results of parts (--json) to join instead of flying");
  command.exclude_others("--merge");  // each part already records how it was flown
  command.add_option("--json", options->json, "file for the numbers");
  command.add_option(
      "--report", options->report,
      "folder for the page with heat maps (campaign.html), and a page of the worst flight of each world");
}

}  // namespace m100::lab
