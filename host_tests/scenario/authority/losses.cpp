// SPDX-License-Identifier: BSD-3-Clause
// Duration of the operator's stop on a line that loses frames, against the second of R15, over many seeds.
#include <algorithm>
#include <array>
#include <cstdio>

#include "host_tests/scenario/authority/battery.h"

namespace m100::authority {
namespace {

constexpr std::size_t kSeeds = 200;
constexpr double kSecond_s = 1.0;         // R15
constexpr double kBeforeStrike_s = 0.01;  // from the stop until the line becomes bad (Stage::kReleasing)

template <int Percent>
void lose(Bench& bench) {
  bench.to_client.plan.drop = bench.to_autopilot.plan.drop = Percent / 100.0;
}

/// A loss rate, and the share of flights that must give control back within the second: five releases are sent in it,
/// and two must arrive.
struct Loss {
  Fault fault;
  double at_least;
};
const std::array kLosses{
    Loss{{.name = "5 % lost", .group = Group::kLine, .strike = lose<5>, .reach = FaultReach::kLate}, 1.0},
    Loss{{.name = "10 % lost", .group = Group::kLine, .strike = lose<10>, .reach = FaultReach::kLate}, 0.99},
    Loss{{.name = "20 % lost", .group = Group::kLine, .strike = lose<20>, .reach = FaultReach::kLate}, 0.97}};

/// Sorted times from the stop.
std::vector<double> times_of(const std::vector<Result>& results, const Loss& loss, bool movement) {
  std::vector<double> times_s;
  for (const Result& result : results) {
    if (result.flown.fault == &loss.fault && result.flown.movement == movement) {
      times_s.push_back(result.verdict.returned_after_s + kBeforeStrike_s);
    }
  }
  std::sort(times_s.begin(), times_s.end());
  return times_s;
}

double share_in_time(const std::vector<double>& times_s) {
  const auto in_time = std::count_if(times_s.begin(), times_s.end(), [](double t_s) { return t_s <= kSecond_s; });
  return static_cast<double>(in_time) / static_cast<double>(std::max<std::size_t>(times_s.size(), 1));
}

template <typename Look>
void for_each_row(const std::vector<Result>& results, const Look& look) {
  for (const Loss& loss : kLosses) {
    for (const bool movement : {false, true}) {
      const std::vector<double> times_s = times_of(results, loss, movement);
      if (!times_s.empty()) {
        look(loss, movement, times_s);
      }
    }
  }
}

}  // namespace

std::vector<Case> losses_battery() {
  std::vector<Case> cases;
  for (const Loss& loss : kLosses) {
    for (std::size_t seed = 1; seed <= kSeeds; ++seed) {
      for (const bool movement : {false, true}) {
        cases.push_back({.fault = &loss.fault, .stage = Stage::kReleasing, .movement = movement, .seed = seed});
      }
    }
  }
  return cases;
}

std::string losses_table(const std::vector<Result>& results) {
  std::string text =
      "| lost both ways | channel | stops | median [s] | 95 % | 99 % | longest | within 1.0 s "
      "|\n|---|---|---|---|---|---|---|---|\n";
  for_each_row(results, [&](const Loss& loss, bool movement, const std::vector<double>& times_s) {
    const auto quantile_s = [&](double share) {
      return times_s[std::min(times_s.size() - 1,
                              static_cast<std::size_t>(share * static_cast<double>(times_s.size())))];
    };
    std::array<char, 160> line{};
    (void)std::snprintf(line.data(), line.size(), "| %.*s | %s | %zu | %.2f | %.2f | %.2f | %.2f | %.1f %% |\n",
                        static_cast<int>(loss.fault.name.find(" lost")), loss.fault.name.data(),
                        movement ? "movement" : "virtual RC", times_s.size(), quantile_s(0.5), quantile_s(0.95),
                        quantile_s(0.99), times_s.back(), 100.0 * share_in_time(times_s));
    text += line.data();
  });
  return text;
}

bool losses_hold(const std::vector<Result>& results) {
  bool hold = true;
  for_each_row(results, [&](const Loss& loss, bool, const std::vector<double>& times_s) {
    hold = hold && share_in_time(times_s) >= loss.at_least;
  });
  return hold;
}

}  // namespace m100::authority
