// SPDX-License-Identifier: BSD-3-Clause
// identify_adversarial_logs [--logs N] [--seed S] [--kind WORDS] [--unseen] [--without K] [--verbose]: the matrix of
// adversarial logs, or of those of unseen, without special test K. Exit code 1 if a required rate is missed.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <string>
#include <vector>

#include "host_tests/property/identify/adversarial_log.h"
#include "host_tests/property/identify/unseen_log.h"
#include "host_tests/property/identify/unseen_log_bound.h"

namespace {

using namespace m100::host_tests;
using m100::lab::identify::IdentifyResult;

struct Options {
  int logs = 20;
  std::uint64_t seed = 1;
  std::string only;
  bool unseen = false;
  bool verbose = false;
  std::size_t without = static_cast<std::size_t>(-1);
};

struct Tally {
  std::array<int, 5> answers{};
  int logs = 0;
  int stopped = 0;    // ended with an error, without a statement
  int hidden = 0;     // false acceptances of effects that the log cannot show
  int unhealthy = 0;  // healthy logs refused although the declared model visibly differs from the vehicle
  // Correctly named changes; intervals that contain the true time; known true sizes, and those inside their intervals.
  int changes = 0, dated = 0, sized = 0, measured = 0;
  std::vector<double> cost_s;  // processor time per minute of log

  void add(const Tally& other) {
    for (std::size_t k = 0; k < answers.size(); ++k) {
      answers[k] += other.answers[k];
    }
    logs += other.logs;
    stopped += other.stopped;
    hidden += other.hidden;
    unhealthy += other.unhealthy;
    changes += other.changes;
    dated += other.dated;
    sized += other.sized;
    measured += other.measured;
    cost_s.insert(cost_s.end(), other.cost_s.begin(), other.cost_s.end());
  }
  int of(Classification answer) const { return answers[static_cast<std::size_t>(answer)]; }
};

std::string in_words(const IdentifyResult& result) {
  std::string out = result.verdict;
  for (const auto& effect : result.effects) {
    out += " +" + effect.name;
  }
  for (const auto& change : result.changes) {
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), " {%s %.1f [%.1f %.1f] LR %.0f rivals %zu}", change.name.c_str(),
                  change.at_s, change.low_s, change.high_s, change.likelihood_ratio, change.rivals.size());
    out += text.data();
  }
  for (const auto& finding : result.findings) {
    out += finding.what == "note" ? "" : " <" + finding.what + (finding.certain ? ">" : "?>");
  }
  for (const auto& left : result.unexplained) {
    out += " | " + left;
  }
  return out;
}

/// Counts wrong answers that the log excuses. @returns the bound of the evidence, or -1 if it was not computed.
double weigh(const AdversarialLog& truth, Classification answer, Tally& tally) {
  if (!truth.evidence || (answer != Classification::kFalseAcceptance && answer != Classification::kFalseRejection &&
                          !(truth.healthy && answer == Classification::kWrongName))) {
    return -1.0;
  }
  const double evidence = truth.evidence();
  tally.hidden += answer == Classification::kFalseAcceptance && evidence < kUnseenLogVisible ? 1 : 0;
  tally.unhealthy += answer != Classification::kFalseAcceptance && evidence >= kUnseenLogVisible ? 1 : 0;
  return evidence;
}

void count_dates(const AdversarialLog& truth, const IdentifyResult& result, Tally& tally) {
  for (const auto& change : result.changes) {
    if (change.name == truth.change) {
      ++tally.changes;
      tally.dated += change.low_s <= truth.change_s && truth.change_s <= change.high_s ? 1 : 0;
      tally.sized += truth.change_size != 0.0 ? 1 : 0;
      const double before = change.parameters.front().value;
      const double size =
          change.name == "gain" || change.name == "frequency" ? truth.change_size * before : truth.change_size;
      tally.measured +=
          truth.change_size != 0.0 && change.size && change.size->low <= size && size <= change.size->high ? 1 : 0;
    }
  }
}

Tally run(const std::string& kind, const Options& options) {
  Tally tally;
  for (int k = 0; k < options.logs; ++k) {
    const std::uint64_t number = options.seed + static_cast<std::uint64_t>(k);
    const AdversarialLog truth = options.unseen ? unseen_log(kind, number) : adversarial_log(kind, number);
    ++tally.logs;
    try {
      const std::clock_t started = std::clock();
      std::string acted;
      const auto result = identify_log(truth, options.unseen ? 40 : 0, [&](m100::lab::identify::SpecialTest test) {
        const auto which = static_cast<std::size_t>(test);
        acted += " " + std::to_string(which);
        return which != options.without;
      });
      const double cost_s = static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
      tally.cost_s.push_back(cost_s * 60.0 / (static_cast<double>(truth.log.size) * truth.log.period_s));
      const Classification answer = classify(truth, result);
      ++tally.answers[static_cast<std::size_t>(answer)];
      const double evidence = weigh(truth, answer, tally);
      count_dates(truth, result, tally);
      if (options.verbose) {
        std::printf("  %llu %s (change at %.1f): %d v/t %.2f bound %.0f cost %.2f fit %.0f acted%s: %s\n",
                    static_cast<unsigned long long>(number), truth.axis.c_str(), truth.change_s,
                    static_cast<int>(answer), result.validation_over_training, evidence, tally.cost_s.back(),
                    result.final_model.fit_percent, acted.c_str(), in_words(result).c_str());
      }
    } catch (const std::exception& refused) {
      ++tally.stopped;
      if (options.verbose) {
        std::printf("  %llu: %s\n", static_cast<unsigned long long>(number), refused.what());
      }
    }
  }
  return tally;
}

Options parsed(const std::vector<std::string>& given) {
  Options out;
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::string value = k + 1 < given.size() ? given[k + 1] : "";
    out.logs = given[k] == "--logs" ? std::atoi(value.c_str()) : out.logs;
    out.seed = given[k] == "--seed" ? std::strtoull(value.c_str(), nullptr, 10) : out.seed;
    out.only = given[k] == "--kind" ? value : out.only;
    out.without = given[k] == "--without" ? std::strtoull(value.c_str(), nullptr, 10) : out.without;
    out.unseen = out.unseen || given[k] == "--unseen";
    out.verbose = out.verbose || given[k] == "--verbose";
  }
  return out;
}

double percent(int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0.0; }

/// Prints the required shares. @returns whether they are kept.
bool judged(const Tally& sick, const Tally& healthy) {
  const int logs = sick.logs + healthy.logs;
  const int refused_anyhow = healthy.of(Classification::kWrongName) + healthy.of(Classification::kFalseRejection);
  const double clean = percent(sick.of(Classification::kFalseAcceptance) - sick.hidden, sick.logs);
  const double wrong = percent(sick.of(Classification::kWrongName) + healthy.of(Classification::kWrongName), logs);
  // A false acceptance counts as fair if the log cannot show the effect.
  const double fair =
      percent(sick.of(Classification::kRight) + sick.of(Classification::kUndecided) + sick.stopped + sick.hidden +
                  healthy.of(Classification::kRight) + healthy.of(Classification::kFalseRejection) + healthy.stopped,
              logs);
  const double price = percent(refused_anyhow - healthy.unhealthy, healthy.logs);
  std::printf(
      "false acceptances %.1f %% (with effects that the log cannot show: %.1f %%), wrong names %.1f %%, right or "
      "undecided %.1f %%\nhealthy refused %.1f %% (with those whose declared model visibly differs from the vehicle: "
      "%.1f %%)\n",
      clean, percent(sick.of(Classification::kFalseAcceptance), sick.logs), wrong, fair, price,
      percent(refused_anyhow, healthy.logs));
  std::printf("changes named %d, true times inside their intervals %d", sick.changes, sick.dated);
  if (sick.sized > 0) {  // the unseen logs do not say how large a change is
    std::printf(", true sizes %d of %d", sick.measured, sick.sized);
  }
  std::printf("\n");
  std::vector<double> cost = sick.cost_s;
  cost.insert(cost.end(), healthy.cost_s.begin(), healthy.cost_s.end());
  std::sort(cost.begin(), cost.end());
  if (!cost.empty()) {
    std::printf("processor time per minute of log: median %.2f s, 95 %% %.2f s, most %.2f s\n", cost[cost.size() / 2],
                cost[cost.size() * 95 / 100], cost.back());
  }
  return clean <= 1.0 && wrong <= 2.0 && fair >= 95.0 && price <= 5.0;
}

}  // namespace

int main(int count, char** words) {
  const Options options = parsed({words + 1, words + count});
  std::printf("%-42s %5s %6s %10s %6s %6s %7s %8s %6s %6s\n", "kind (simulated)", "logs", "right", "undecided", "wrong",
              "clean", "unseen", "healthy-", "error", "s/min");
  Tally sick, healthy;
  for (const std::string& kind : options.unseen ? unseen_log_kinds() : adversarial_log_kinds()) {
    if (kind.find(options.only) == std::string::npos) {
      continue;
    }
    const Tally one = run(kind, options);
    double sum_s = 0.0;
    for (const double cost_s : one.cost_s) {
      sum_s += cost_s;
    }
    std::printf("%-42s %5d %6d %10d %6d %6d %7d %8d %6d %6.2f\n", kind.c_str(), one.logs, one.answers[0],
                one.answers[1], one.answers[2], one.answers[3], one.hidden, one.answers[4], one.stopped,
                sum_s / std::max<double>(1.0, static_cast<double>(one.cost_s.size())));
    (kind.rfind("healthy", 0) == 0 ? healthy : sick).add(one);
    std::fflush(stdout);
  }
  return judged(sick, healthy) ? 0 : 1;
}
