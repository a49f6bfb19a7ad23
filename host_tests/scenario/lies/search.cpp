// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/lies/search.h"

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
    fault.happenings = drawn_happenings(is_operator(channel), kLatest_s, random);
  }
  return fault;
}

Fault neighbour_of(const Channel& channel, const Fault& fault, sim::Random& random) {
  Fault next = fault;
  if (channel.kind != Channel::Kind::kWave) {
    next.happenings = neighbour_of(fault.happenings, is_operator(channel), kLatest_s, random);
  } else if (random.uniform() < 0.05) {
    next.task = kWaveTasks[random.next() % kWaveTasks.size()];
  } else {
    next.wave = neighbour_of(fault.wave, channel.sizes, kEarliest_s, kLatest_s, random);
  }
  return next;
}

}  // namespace

std::string to_text(const Fault& fault) {
  return fault.task + " | " + (fault.wave.empty() ? to_text(fault.happenings) : to_text(fault.wave));
}

Fault fault_of(const Channel& channel, const std::string& text) {
  const std::size_t bar = text.find(" | ");
  if (bar == std::string::npos) {
    throw std::invalid_argument("a fault without a task: " + text);
  }
  Fault fault{.task = text.substr(0, bar), .wave = {}, .happenings = {}};
  if (channel.kind == Channel::Kind::kWave) {
    fault.wave = waveform_of(text.substr(bar + 3));
  } else {
    fault.happenings = happenings_of(text.substr(bar + 3));
  }
  return fault;
}

double score_of(const Channel& channel, const Harm& harm) {
  return channel.kind == Channel::Kind::kWave ? harm.away_m : harm.farthest_m;
}

Found searched(const Channel& channel, int flights, std::uint64_t seed, const Fault& known) {
  sim::Random random(seed, channel.name);
  std::vector<Found> best;
  const bool has_known = !known.wave.empty() || !known.happenings.empty();
  for (int flight = 0; flight < flights; ++flight) {
    const bool draws = best.empty() || flight < static_cast<int>(kDrawnShare * flights);
    Found found;
    found.fault = flight == 0 && has_known ? known
                  : draws                  ? drawn_fault(channel, random)
                                           : neighbour_of(channel, best[random.next() % best.size()].fault, random);
    found.harm = harm_of(channel, found.fault, 1);
    best.push_back(found);
    std::stable_sort(best.begin(), best.end(), [&](const Found& a, const Found& b) {
      return score_of(channel, a.harm) > score_of(channel, b.harm);
    });
    best.resize(std::min(best.size(), kElite));
  }
  best.front().flights = flights;
  return best.front();
}

}  // namespace m100::scenario
