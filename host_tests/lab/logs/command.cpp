// SPDX-License-Identifier: BSD-3-Clause
// m100-lab logs: lists the content of a log of any format, and proposes a column map for recognised names.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/proposal/example_map.h"
#include "host_tests/lab/logs/proposal/propose.h"
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
    constexpr std::size_t kShownStretches = 8;
    const std::size_t stretches = topic.stretches.size() > 1 ? topic.stretches.size() : 0;
    for (std::size_t i = 0; i < std::min(kShownStretches, stretches); ++i) {
      std::printf("      stretch %zu of %zu: %.2f to %.2f s, %zu messages\n", i + 1, stretches,
                  topic.stretches[i].from_s, topic.stretches[i].to_s, topic.stretches[i].samples);
    }
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

Json to_json(const logs::RawLog& log, const std::vector<logs::TopicSummary>& topics, double duration_s,
             const std::optional<logs::Proposal>& proposal) {
  Json list = Json::array();
  for (const logs::TopicSummary& topic : topics) {
    Json fields = Json::array();
    for (const std::string& field : topic.fields) {
      fields.push_back(printable(field));
    }
    Json stretches = Json::array();
    for (const logs::Stretch& stretch : topic.stretches) {
      stretches.push_back({{"from_s", stretch.from_s}, {"to_s", stretch.to_s}, {"messages", stretch.samples}});
    }
    list.push_back({{"name", printable(topic.name)},
                    {"type", printable(topic.type)},
                    {"messages", topic.messages},
                    {"from_s", topic.from_s},
                    {"to_s", topic.to_s},
                    {"rate_hz", topic.rate_hz},
                    {"gaps", topic.gaps},
                    {"longest_gap_s", topic.longest_gap_s},
                    {"stretches", std::move(stretches)},
                    {"fields", std::move(fields)}});
  }
  Json out{{"file", printable(log.file())}, {"format", log.format()}, {"duration_s", duration_s},
           {"topics", std::move(list)},     {"notes", log.notes()},   {"proposed", nullptr}};
  if (proposal) {
    out["proposed"] = {{"dialect", proposal->dialect}, {"map", proposal->toml}};
  }
  return out;
}

void run(const LogsOptions& options) {
  companion::FileUse()
      .reads("--log", options.log)
      .writes("--json", options.json)
      .writes("--propose", options.map)
      .check();
  const std::unique_ptr<logs::RawLog> log = logs::open_log(options.log);
  const std::vector<std::string> names = logs::first_names(*log);
  if (log->format() == "CSV" && std::all_of(names.begin(), names.end(), [&](const std::string& name) {
        return logs::numbers_of(*log, name).empty();
      })) {
    throw InputError(options.log, 0, "", "is text, but no log: its first 200 columns hold no numbers");
  }
  const std::vector<logs::TopicSummary> topics = log->topics();
  double from_s = 0.0;
  double to_s = 0.0;
  bool timed = false;
  for (const logs::TopicSummary& topic : topics) {
    if (topic.rate_hz > 0.0) {
      for (const logs::Stretch& stretch : topic.stretches) {
        from_s = timed ? std::min(from_s, stretch.from_s) : stretch.from_s;
        to_s = timed ? std::max(to_s, stretch.to_s) : stretch.to_s;
        timed = true;
      }
    }
  }
  print(*log, topics, to_s - from_s);
  const std::optional<logs::Proposal> proposal = logs::propose(*log);
  write_json(options.json, to_json(*log, topics, to_s - from_s, proposal));
  if (!proposal) {
    std::printf(
        "No map is proposed, because the column names are unknown. Write a map that names the columns, for example:\n"
        "%sCheck the signs and units. m100-lab reference column_keys prints every signal that a map may have.\n",
        logs::example_map(*log).c_str());
    if (!options.map.empty()) {
      throw companion::AnswerIsNo();
    }
    return;
  }
  if (options.map.empty()) {
    std::printf("Recognised: %s (--propose MAP.toml writes a column map)\n", proposal->dialect.c_str());
    return;
  }
  write_whole_file(options.map, proposal->toml, "--propose");
  std::printf("Recognised: %s; wrote %s\n", proposal->dialect.c_str(), printable(options.map).c_str());
}

}  // namespace

void add_logs(companion::CommandLine& lab) {
  const auto [app, options] = lab.add_subcommand<LogsOptions>(
      "logs", "list the content of a log of any format, and propose a column map for it", run);
  app.add_option("log,--log", options->log, "CSV, MAT-file, ULog, ArduPilot .bin, ROS 1 or ROS 2 bag").required();
  app.add_option("--json", options->json, "the content as JSON");
  app.add_option("--propose", options->map, "column map (TOML) to write; exit code 1 if the names are unknown");
}

}  // namespace m100::lab
