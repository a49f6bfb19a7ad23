// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/sensor_faults/fault_search.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace m100::scenario {
namespace {

constexpr std::size_t kElite = 4;
constexpr double kDrawnShare = 1.0 / 3.0;
constexpr std::array<const char*, 2> kWaveTasks{"hover", "step_3m"};

bool is_operator(const Channel& channel) { return channel.kind == Channel::Kind::kOperator; }

Fault drawn_fault(const Channel& channel, sim::Random& random) {
  Fault fault;
  if (channel.kind == Channel::Kind::kWave) {
    fault.task = kWaveTasks[random.next() % kWaveTasks.size()];
    fault.wave = drawn_wave(channel.sizes, kEarliest_s, kLatest_s, random);
  } else {
    fault.command_faults = drawn_command_faults(is_operator(channel), kLatest_s, random);
  }
  return fault;
}

Fault neighbour_of(const Channel& channel, const Fault& fault, sim::Random& random) {
  Fault next = fault;
  if (channel.kind != Channel::Kind::kWave) {
    next.command_faults = neighbour_of(fault.command_faults, is_operator(channel), kLatest_s, random);
  } else if (random.uniform() < 0.05) {
    next.task = kWaveTasks[random.next() % kWaveTasks.size()];
  } else {
    next.wave = neighbour_of(fault.wave, channel.sizes, kEarliest_s, kLatest_s, random);
  }
  return next;
}

}  // namespace

std::string to_text(const Fault& fault) {
  return fault.task + " | " + (fault.wave.empty() ? to_text(fault.command_faults) : to_text(fault.wave));
}

Fault fault_of(const Channel& channel, const std::string& text) {
  const std::size_t bar = text.find(" | ");
  if (bar == std::string::npos) {
    throw std::invalid_argument("a fault without a task: " + text);
  }
  Fault fault{.task = text.substr(0, bar), .wave = {}, .command_faults = {}};
  if (channel.kind == Channel::Kind::kWave) {
    fault.wave = waveform_of(text.substr(bar + 3));
  } else {
    fault.command_faults = command_faults_of(text.substr(bar + 3));
  }
  return fault;
}

double score_of(const Channel& channel, const FaultEffect& effect) {
  return channel.kind == Channel::Kind::kWave ? effect.away_m : effect.farthest_m;
}

SearchResult run_search(const Channel& channel, int flights, std::uint64_t seed, const Fault& known) {
  sim::Random random(seed, channel.name);
  std::vector<SearchResult> best;
  const bool has_known = !known.wave.empty() || !known.command_faults.empty();
  for (int flight = 0; flight < flights; ++flight) {
    const bool draws = best.empty() || flight < static_cast<int>(kDrawnShare * flights);
    SearchResult found;
    found.fault = flight == 0 && has_known ? known
                  : draws                  ? drawn_fault(channel, random)
                                           : neighbour_of(channel, best[random.next() % best.size()].fault, random);
    found.effect = effect_of(channel, found.fault, 1);
    best.push_back(found);
    std::stable_sort(best.begin(), best.end(), [&](const SearchResult& a, const SearchResult& b) {
      return score_of(channel, a.effect) > score_of(channel, b.effect);
    });
    best.resize(std::min(best.size(), kElite));
  }
  best.front().flights = flights;
  return best.front();
}

}  // namespace m100::scenario
