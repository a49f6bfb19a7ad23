// SPDX-License-Identifier: BSD-3-Clause
// m100-lab logs: lists the content of a log of any format, and proposes a column map for recognised names.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/propose.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct LogsOptions {
  std::string log, json, map;
};

void print(const logs::RawLog& log, const std::vector<logs::TopicSummary>& topics, double duration_s) {
  constexpr std::size_t kShownFields = 24;
  std::printf("%s: %s, %zu topics, %.2f s\n", printable(log.file()).c_str(), log.format().c_str(), topics.size(),
              duration_s);
  for (const logs::TopicSummary& topic : topics) {
    const std::string name = topic.name.empty() ? "(one table)" : printable(topic.name, 80);
    std::printf("  %-36s %7zu messages %8.2f Hz  %8.2f to %8.2f s", name.c_str(), topic.messages, topic.rate_hz,
                topic.from_s, topic.to_s);
    topic.gaps > 0 ? std::printf("  %zu gaps, longest %.2f s\n", topic.gaps, topic.longest_gap_s) : std::printf("\n");
    std::string fields;
    for (std::size_t i = 0; i < std::min(kShownFields, topic.fields.size()); ++i) {
      fields += (i == 0 ? "" : ", ") + printable(topic.fields[i], 60);
    }
    const std::size_t hidden = topic.fields.size() - std::min(kShownFields, topic.fields.size());
    std::printf("      %s%s\n", fields.c_str(),
                hidden > 0 ? (", and " + std::to_string(hidden) + " more").c_str() : "");
  }
  for (const std::string& note : log.notes()) {
    std::printf("  note: %s\n", printable(note).c_str());
  }
}

nlohmann::ordered_json to_json(const logs::RawLog& log, const std::vector<logs::TopicSummary>& topics,
                               double duration_s, const std::optional<logs::Proposal>& proposal) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const logs::TopicSummary& topic : topics) {
    nlohmann::ordered_json fields = nlohmann::ordered_json::array();
    for (const std::string& field : topic.fields) {
      fields.push_back(printable(field));
    }
    list.push_back({{"name", printable(topic.name)},
                    {"type", printable(topic.type)},
                    {"messages", topic.messages},
                    {"from_s", topic.from_s},
                    {"to_s", topic.to_s},
                    {"rate_hz", topic.rate_hz},
                    {"gaps", topic.gaps},
                    {"longest_gap_s", topic.longest_gap_s},
                    {"fields", std::move(fields)}});
  }
  nlohmann::ordered_json out{{"file", printable(log.file())}, {"format", log.format()}, {"duration_s", duration_s},
                             {"topics", std::move(list)},     {"notes", log.notes()},   {"proposed", nullptr}};
  if (proposal) {
    out["proposed"] = {{"dialect", proposal->dialect}, {"map", proposal->toml}};
  }
  return out;
}

void write_text(const std::string& file, const std::string& option, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) {
    throw InputError(file, 0, option, "cannot be written");
  }
}

/// A column that may be the log's clock, and the scale that makes seconds of it.
struct ClockColumn {
  std::string name;
  const char* scale = "1";
};

/// The values of a column; none if it cannot be read as numbers.
std::vector<double> numbers_of(const logs::RawLog& log, const std::string& name) {
  try {
    return log.column(name, "time").values;
  } catch (const InputError&) {
    return {};
  }
}

/// The log's first columns, as many as are searched for numbers: the search of a wide file must end.
std::vector<std::string> first_names(const logs::RawLog& log) {
  constexpr std::size_t kMaxTried = 200;
  std::vector<std::string> names = log.names();
  names.resize(std::min(names.size(), kMaxTried));
  return names;
}

/// The first column that increases at every row and is no row number, preferably one with the name of a time. The scale
/// follows from its mean step: flights are logged once a second to ten thousand times a second.
std::optional<ClockColumn> clock_of(const logs::RawLog& log) {
  std::optional<ClockColumn> found;
  for (const std::string& name : first_names(log)) {
    const std::vector<double> t = numbers_of(log, name);
    const bool increases = t.size() > 2 && std::adjacent_find(t.begin(), t.end(), std::greater_equal<>()) == t.end();
    const double step = increases ? (t.back() - t.front()) / static_cast<double>(t.size() - 1) : 0.0;
    if (!(step > 0.0) || step == 1.0) {
      continue;
    }
    const char* const scale = step < 1.0 ? "1" : step < 1e3 ? "1e-3" : step < 1e6 ? "1e-6" : "1e-9";
    const bool is_named = name.find("ime") != std::string::npos || name.find("stamp") != std::string::npos ||
                          name == "t" || name.ends_with(".t") || name.ends_with("t_s");
    if (!found || is_named) {
      found = {.name = name, .scale = scale};
    }
    if (is_named) {
      break;
    }
  }
  return found;
}

/// Explains how to map a log with unknown names: a map in four lines, with columns of this file as examples.
void explain_mapping(const logs::RawLog& log) {
  const std::optional<ClockColumn> clock = clock_of(log);
  std::vector<std::string> names = log.names();
  std::erase_if(names, [&](const std::string& name) { return clock && name == clock->name; });
  const auto example = [&](std::size_t i) { return i < names.size() ? printable(names[i], 60) : std::string("..."); };
  std::printf(
      "No map is proposed, because the column names are unknown. Write a map that names the columns, for example:\n"
      "  time = { column = \"%s\", scale = %s }  # the scale converts to seconds\n"
      "  [signals]\n"
      "  stick_roll = { column = \"%s\", offset = -1500 }  # counts from neutral\n"
      "  attitude_roll = { column = \"%s\", scale = 0.017453292519943 }  # degrees to radians\n"
      "m100-lab reference prints every signal that a map may have.\n",
      clock ? printable(clock->name, 60).c_str() : "...", clock ? clock->scale : "1", example(0).c_str(),
      example(1).c_str());
}

void run(const LogsOptions& options) {
  companion::FileUse()
      .reads("--log", options.log)
      .writes("--json", options.json)
      .writes("--propose", options.map)
      .check();
  const std::unique_ptr<logs::RawLog> log = logs::open_log(options.log);
  const std::vector<std::string> names = first_names(*log);
  if (log->format() == "CSV" && std::all_of(names.begin(), names.end(),
                                            [&](const std::string& name) { return numbers_of(*log, name).empty(); })) {
    throw InputError(options.log, 0, "", "is text, but no log: its first 200 columns hold no numbers");
  }
  const std::vector<logs::TopicSummary> topics = log->topics();
  double from_s = 0.0;
  double to_s = 0.0;
  bool timed = false;
  for (const logs::TopicSummary& topic : topics) {
    if (topic.rate_hz > 0.0) {
      from_s = timed ? std::min(from_s, topic.from_s) : topic.from_s;
      to_s = timed ? std::max(to_s, topic.to_s) : topic.to_s;
      timed = true;
    }
  }
  print(*log, topics, to_s - from_s);
  const std::optional<logs::Proposal> proposal = logs::propose(*log);
  if (!options.json.empty()) {
    const nlohmann::ordered_json out = to_json(*log, topics, to_s - from_s, proposal);
    write_text(options.json, "--json",
               out.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  }
  if (!proposal) {
    explain_mapping(*log);
    if (!options.map.empty()) {
      throw CLI::RuntimeError(kAnswerIsNo);
    }
    return;
  }
  if (options.map.empty()) {
    std::printf("Recognised: %s (--propose MAP.toml writes a column map)\n", proposal->dialect.c_str());
    return;
  }
  write_text(options.map, "--propose", proposal->toml);
  std::printf("Recognised: %s; wrote %s\n", proposal->dialect.c_str(), printable(options.map).c_str());
}

}  // namespace

void add_logs(CLI::App& lab) {
  CLI::App* app =
      lab.add_subcommand("logs", "list the content of a log of any format, and propose a column map for it");
  auto options = std::make_shared<LogsOptions>();
  app->add_option("log,--log", options->log, "CSV, MAT-file, ULog, ArduPilot .bin, ROS 1 or ROS 2 bag")->required();
  app->add_option("--json", options->json, "the content as JSON");
  app->add_option("--propose", options->map, "column map (TOML) to write; exit code 1 if the names are unknown");
  app->callback([options] { run(*options); });
}

}  // namespace m100::lab
