// SPDX-License-Identifier: BSD-3-Clause
// identify_scaling: processor time and memory of identify against the length of the log. Each log is analysed in a
// separate process, so that its memory can be measured.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "firmware/companion/command_line.h"
#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::hidden {
namespace {

constexpr double kMax_MB = 120.0;  // limit for an hour

struct Cost {
  double minutes = 0.0;
  double seconds = 0.0;  ///< processor time of the analysis alone
  double megabytes = 0.0;
};

/// Makes a log with a hidden dead zone. With `analyse` it also identifies the log and ends the process with 0 if just
/// the dead zone is named, otherwise with 1.
void work(double minutes, bool analyse) {
  FlightPlan plan;
  plan.axis = "roll";
  plan.seed = 3;
  plan.length_s = 60.0 * minutes;
  plan.hidden["dead_zone"] = 25.0;
  const logs::FlightLog log = fly(plan);
  if (!analyse) {
    return;
  }
  identify::Request request;
  request.axis = "roll";
  request.declared = {"second_order", "transport_delay"};
  request.train = {{3.0, 0.65 * plan.length_s}};
  request.validate = {{0.65 * plan.length_s, plan.length_s - 1.0}};
  request.log = request.validation_log = &log;
  const identify::IdentifyResult result = identify::identify_axis(request);
  std::_Exit(result.effects.size() == 1 && result.effects[0].name == "dead_zone" ? 0 : 1);
}

rusage usage_of(double minutes, bool analyse, bool& right) {
  const pid_t child = fork();
  if (child == 0) {
    work(minutes, analyse);
    std::_Exit(0);
  }
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  right = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return used;
}

double seconds(const rusage& used) {
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

void write_page(const std::string& file, const std::vector<Cost>& costs) {
  plot::Page page("identify: processor time and memory against the length of the log");
  page.paragraph("One stick axis, all candidates, intervals; a dead zone is hidden and must be found; one core.");
  plot::Figure time{.title = "Processor time", .x_label = "log [min]", .y_label = "time [s]"};
  plot::Figure memory{.title = "Largest memory of the process", .x_label = "log [min]", .y_label = "memory [MB]"};
  time.lines.push_back({.name = ""});
  memory.lines.push_back({.name = ""});
  std::vector<std::vector<std::string>> rows{{"log [min]", "time [s]", "time per minute [s]", "memory [MB]"}};
  for (const Cost& cost : costs) {
    time.lines[0].x.push_back(cost.minutes);
    time.lines[0].y.push_back(cost.seconds);
    memory.lines[0].x.push_back(cost.minutes);
    memory.lines[0].y.push_back(cost.megabytes);
    rows.push_back({plot::number(cost.minutes), plot::number(cost.seconds), plot::number(cost.seconds / cost.minutes),
                    plot::number(cost.megabytes)});
  }
  page.table(rows);
  page.figure(time, "Processor time");
  page.figure(memory, "Memory");
  page.write(file);
}

}  // namespace
}  // namespace m100::lab::hidden

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): out of memory, which ends it as well
  using namespace m100::lab::hidden;
  m100::companion::CommandLine app{"identify_scaling: time and memory of identify against the length of the log"};
  std::vector<double> minutes{1, 2, 4, 8, 16, 30, 60};
  std::string report;
  app.add_option("--minutes", minutes, "lengths of the logs [min], separated by commas").takes_commas();
  app.add_option("--report", report, "HTML page with the figure");
  app.read(argc, argv);
  std::vector<Cost> costs;
  std::printf("%8s %10s %14s %10s\n", "min", "cpu [s]", "per minute [s]", "MB");
  bool all_right = true;
  for (const double length : minutes) {
    bool right = false;
    const rusage made = usage_of(length, false, right);
    const rusage used = usage_of(length, true, right);
    all_right = all_right && right;
    costs.push_back({length, seconds(used) - seconds(made), static_cast<double>(used.ru_maxrss) / 1024});
    std::printf("%8.0f %10.2f %14.3f %10.0f%s\n", length, costs.back().seconds, costs.back().seconds / length,
                costs.back().megabytes, right ? "" : "  (dead zone not named)");
    std::fflush(stdout);
  }
  if (!report.empty()) {
    write_page(report, costs);
  }
  // Test for linear cost: a minute of the last log costs less than 1.5 times the mean over all logs.
  double mean = 0.0;
  for (const Cost& cost : costs) {
    mean += cost.seconds / cost.minutes / static_cast<double>(costs.size());
  }
  const bool linear = costs.back().seconds / costs.back().minutes < 1.5 * mean;
  return all_right && linear && costs.back().megabytes < kMax_MB ? 0 : 1;
}
