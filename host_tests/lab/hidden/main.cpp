// SPDX-License-Identifier: BSD-3-Clause
// hidden_effects: flies logs with hidden effects, analyses them without knowing the effects, and counts right answers.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/hidden/confusion.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::hidden {
namespace {

Json to_json(const std::vector<Outcome>& outcomes) {
  Json out;
  for (const Score& score : scores(outcomes)) {
    out["scores"].push_back(
        {{"what", score.what}, {"right", score.right}, {"count", score.count}, {"goal", score.goal}});
  }
  for (const Outcome& one : outcomes) {
    out["logs"].push_back({{"hidden", one.hidden_case.plan.hidden},
                           {"axis", one.hidden_case.plan.axis},
                           {"seed", one.hidden_case.plan.seed},
                           {"size", one.hidden_case.size},
                           {"found", one.found},
                           {"verdict", one.verdict},
                           {"unexplained", one.unexplained},
                           {"right", one.right},
                           {"before", one.before},
                           {"after", one.after},
                           {"elapsed_s", one.elapsed_s}});
  }
  return out;
}

void print(const std::vector<Outcome>& outcomes, bool every_label) {
  std::map<std::string, std::pair<int, int>> labels;
  for (const Outcome& one : outcomes) {
    auto& [right, count] = labels[one.hidden_case.label];
    right += one.right ? 1 : 0;
    ++count;
  }
  for (const auto& [label, tally] : labels) {
    if (every_label || tally.first < tally.second) {
      std::printf("  %-44s %3d of %3d\n", label.c_str(), tally.first, tally.second);
    }
  }
  for (const Score& score : scores(outcomes)) {
    std::printf("%-44s %3zu of %3zu = %5.1f %%%s\n", score.what.c_str(), score.right, score.count, 100 * score.share(),
                score.goal > 0 ? (score.share() >= score.goal ? "  (goal met)" : "  (BELOW GOAL)") : "");
  }
}

void write_page(const std::string& file, const std::vector<Outcome>& outcomes) {
  plot::Page page("Hidden effects: hidden and named");
  page.paragraph(std::to_string(outcomes.size()) +
                 " simulated logs of 45 s, made by a vehicle model that shares no code with the identification.");
  std::vector<std::vector<std::string>> rows{{"", "right", "logs", "share [%]", "goal [%]"}};
  for (const Score& score : scores(outcomes)) {
    rows.push_back({score.what, std::to_string(score.right), std::to_string(score.count),
                    plot::number(100 * score.share()), score.goal > 0 ? plot::number(100 * score.goal) : ""});
  }
  page.table(rows);
  page.figure(matrix_of(outcomes), "Single effects of all sizes, by the first name given. Numbers of logs.");
  page.write(file);
}

}  // namespace
}  // namespace m100::lab::hidden

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): out of memory, which ends it as well
  using namespace m100::lab::hidden;
  m100::companion::CommandLine app{
      "hidden_effects: a confusion matrix of the residual analysis on simulated logs with hidden effects"};
  std::size_t count = 600;
  std::uint64_t seed = 1;
  unsigned threads = 2;
  std::string only;
  std::string json;
  std::string report;
  std::string write;
  bool verbose = false;
  app.add_option("--logs", count, "number of logs");
  app.add_option("--seed", seed, "seed of the list of cases");
  app.add_option("--threads", threads, "number of threads");
  app.add_option("--only", only, "run only the cases whose label contains this text");
  app.add_option("--json", json, "file for all answers as JSON");
  app.add_option("--report", report, "HTML page with the table and the matrix");
  app.add_option("--write", write, "folder for the logs as CSV with their column maps");
  app.add_flag("--verbose", verbose, "print each wrong answer at once");
  app.read(argc, argv);
  std::vector<Case> list = cases(count, seed);
  std::erase_if(list, [&](const Case& one) { return one.label.find(only) == std::string::npos; });
  for (std::size_t k = 0; !write.empty() && k < list.size(); ++k) {
    const m100::lab::logs::FlightLog log = fly(list[k].plan);
    std::string name = list[k].label + "_" + std::to_string(list[k].plan.seed);
    std::replace(name.begin(), name.end(), ' ', '_');
    m100::lab::logs::write_csv(log, write + "/" + name + ".csv");
    m100::lab::logs::write_column_map(log, write + "/" + name + ".toml");
  }
  const std::vector<Outcome> outcomes = analyse_all(list, threads, [&](const Outcome& one, std::size_t finished) {
    if (verbose && !one.right) {
      std::printf("%s size %d seed %llu: %s, %s%s%s %.4f -> %.4f\n", one.hidden_case.label.c_str(),
                  one.hidden_case.size, static_cast<unsigned long long>(one.hidden_case.plan.seed),
                  m100::lab::plot::joined(one.found, " + ").c_str(), one.verdict.c_str(),
                  one.unexplained.empty() ? "" : (": " + m100::lab::plot::joined(one.unexplained, " + ")).c_str(),
                  one.failure.c_str(), one.before, one.after);
    }
    if (finished % 20 == 0) {
      std::fprintf(stderr, "%zu of %zu\n", finished, list.size());
    }
  });
  print(outcomes, verbose);
  if (!json.empty()) {
    std::ofstream(json) << to_json(outcomes).sorted().dump(1) << "\n";
  }
  if (!report.empty()) {
    write_page(report, outcomes);
  }
  const std::vector<Score> all = scores(outcomes);
  return std::all_of(all.begin(), all.end(), [](const Score& s) { return s.share() >= s.goal; }) ? 0 : 1;
}
