// SPDX-License-Identifier: BSD-3-Clause
// identify_adversary [--logs N] [--seed S] [--kind WORDS] [--verbose]: the matrix of adversarial logs. Exit code 1
// where a rate that was asked for is missed.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "host_tests/property/identify/adversary.h"

namespace {

using namespace m100::host_tests;

struct Tally {
  std::array<int, 5> answers{};
  int logs = 0;
  int refused = 0;  // ended with an error
  double seconds = 0.0;
};

std::string in_words(const m100::lab::identify::IdentifyResult& result) {
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

Tally run(const std::string& kind, int logs, std::uint64_t seed, bool verbose) {
  Tally tally;
  for (int k = 0; k < logs; ++k) {
    const std::uint64_t number = seed + static_cast<std::uint64_t>(k);
    const Adversary truth = adversary(kind, number);
    ++tally.logs;
    try {
      const auto result = ask(truth);
      const Answer answer = judge(truth, result);
      ++tally.answers[static_cast<std::size_t>(answer)];
      tally.seconds += result.elapsed_s;
      if (verbose) {
        std::printf("  %llu (change at %.1f): %d %.2f %s\n", static_cast<unsigned long long>(number), truth.change_s,
                    static_cast<int>(answer), result.validation_over_training, in_words(result).c_str());
      }
    } catch (const std::exception& refused) {
      ++tally.refused;
      if (verbose) {
        std::printf("  %llu: %s\n", static_cast<unsigned long long>(number), refused.what());
      }
    }
  }
  return tally;
}

}  // namespace

int main(int count, char** words) {
  int logs = 20;
  std::uint64_t seed = 1;
  std::string only;
  bool verbose = false;
  const std::vector<std::string> given(words + 1, words + count);
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::string value = k + 1 < given.size() ? given[k + 1] : "";
    logs = given[k] == "--logs" ? std::atoi(value.c_str()) : logs;
    seed = given[k] == "--seed" ? std::strtoull(value.c_str(), nullptr, 10) : seed;
    only = given[k] == "--kind" ? value : only;
    verbose = verbose || given[k] == "--verbose";
  }
  std::printf("%-38s %5s %6s %10s %6s %6s %8s %6s %6s\n", "kind (simulated)", "logs", "right", "undecided", "wrong",
              "clean", "healthy-", "error", "s/log");
  Tally sick, healthy;
  for (const std::string& kind : adversary_kinds()) {
    if (kind.find(only) == std::string::npos) {
      continue;
    }
    const Tally one = run(kind, logs, seed, verbose);
    std::printf("%-38s %5d %6d %10d %6d %6d %8d %6d %6.2f\n", kind.c_str(), one.logs, one.answers[0], one.answers[1],
                one.answers[2], one.answers[3], one.answers[4], one.refused, one.seconds / std::max(1, one.logs));
    Tally& sum = kind.rfind("healthy", 0) == 0 ? healthy : sick;
    sum.logs += one.logs;
    for (std::size_t k = 0; k < one.answers.size(); ++k) {
      sum.answers[k] += one.answers[k];
    }
    std::fflush(stdout);
  }
  const auto percent = [](int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0.0; };
  const double clean = percent(sick.answers[3], sick.logs);
  const double wrong = percent(sick.answers[2] + healthy.answers[2], sick.logs + healthy.logs);
  const double fair =
      percent(sick.answers[0] + sick.answers[1] + healthy.answers[0] + healthy.answers[4], sick.logs + healthy.logs);
  const double price = percent(healthy.answers[2] + healthy.answers[4], healthy.logs);
  std::printf("false clean bills %.1f %%, wrong names %.1f %%, right or undecided %.1f %%, healthy refused %.1f %%\n",
              clean, wrong, fair, price);
  return clean <= 1.0 && wrong <= 2.0 && fair >= 95.0 && price <= 5.0 ? 0 : 1;
}
