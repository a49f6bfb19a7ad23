// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/rates.h"

#include <iomanip>
#include <nlohmann/json.hpp>

#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::experiments {
namespace {

const char* name_of(link::Channel channel) { return channel == link::Channel::kMovement ? "movement" : "virtual_rc"; }

std::string name_of(const RateSetting& setting) {
  return std::string(name_of(setting.channel)) + " " + plot::number(setting.rate_hz) + " Hz" +
         (setting.by_name ? " by name" : "");
}

std::vector<std::vector<std::string>> table(const std::vector<RateCost>& costs) {
  std::vector<std::vector<std::string>> rows{{"pose RMS [m]"}};
  for (const TaskResult& result : costs.front().tasks) {
    rows[0].push_back(result.task->task + ", " + result.task->condition);
  }
  for (const RateCost& cost : costs) {
    rows.push_back({name_of(cost.setting)});
    for (const TaskResult& result : cost.tasks) {
      rows.back().push_back(result.refused > 0 ? "refused" : plot::number(result.mean.pose_m));
    }
  }
  return rows;
}

}  // namespace

const std::vector<RateSetting>& rate_settings() {
  using enum link::Channel;
  static const std::vector<RateSetting> settings{
      {kVirtualRc, 5, false}, {kVirtualRc, 10, false}, {kVirtualRc, 25, false}, {kVirtualRc, 100, true},
      {kMovement, 10, false}, {kMovement, 25, false},  {kMovement, 50, false},  {kMovement, 100, true}};
  return settings;
}

std::vector<RateCost> fly_rates(const SuiteOptions& options, const std::vector<RateSetting>& settings) {
  std::vector<RateCost> costs;
  for (const RateSetting& setting : settings) {
    SuiteOptions suite = options;
    suite.channel = setting.channel;
    suite.rate_hz = setting.by_name ? 0.0 : setting.rate_hz;
    suite.paper_100_hz = setting.by_name;
    suite.literal_steps = false;
    if (options.progress) {
      options.progress(name_of(setting));
    }
    RateCost cost{.setting = setting, .tasks = {}};
    for (const char* const task : {"hover", "step", "trajectory"}) {
      if (options.only.empty() || options.only == task) {
        suite.only = task;
        for (TaskResult& result : fly_suite(suite)) {
          cost.tasks.push_back(std::move(result));
        }
      }
    }
    costs.push_back(std::move(cost));
  }
  return costs;
}

void print_rates(std::ostream& out, const std::vector<RateCost>& costs) {
  for (const std::vector<std::string>& row : table(costs)) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out << std::left << std::setw(i == 0 ? 26 : 18) << row[i];
    }
    out << "\n";
  }
}

nlohmann::json rates_to_json(const std::vector<RateCost>& costs) {
  nlohmann::json all = nlohmann::json::array();
  for (const RateCost& cost : costs) {
    all.push_back({{"channel", name_of(cost.setting.channel)},
                   {"rate_hz", cost.setting.rate_hz},
                   {"by_name", cost.setting.by_name},
                   {"tasks", to_json(cost.tasks)}});
  }
  return all;
}

void write_rates_report(const std::string& folder, const std::vector<RateCost>& costs, const std::string& about) {
  plot::Page page("Tracking error against the command rate, simulated");
  page.paragraph(about);
  page.table(table(costs));
  page.write(folder + "/rates.html");
}

}  // namespace m100::lab::experiments
