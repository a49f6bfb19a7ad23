// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/campaign/outcome.h"

namespace m100::lab::campaign {

/// A plant file, and its name in tables.
struct World {
  std::string name;    ///< the file name without folder and .toml
  std::string path;    ///< as given
  std::string digest;  ///< SHA-256 of the file's bytes, in hexadecimal
  sim::Plant plant;
};

/// A part of all flights: number `part` of `parts`, counted from 1. Flight i = 0, 1, ... is in part i % parts + 1.
struct Share {
  std::size_t part = 1;
  std::size_t parts = 1;
};

/// A campaign: worlds x tasks x seeds. Flights are numbered from 0 in this order; the seed varies fastest.
struct Campaign {
  std::vector<World> worlds;
  std::vector<Task> tasks;
  std::uint64_t first_seed = 1;
  std::size_t flights = 10;  ///< of each task in each world
  Settings settings;
  std::vector<std::string> options{};  ///< command-line words that repeat the settings

  std::size_t size() const { return worlds.size() * tasks.size() * flights; }
  const World& world_of(std::size_t flight) const { return worlds[flight / flights / tasks.size()]; }
  const Task& task_of(std::size_t flight) const { return tasks[flight / flights % tasks.size()]; }
  std::uint64_t seed_of(std::size_t flight) const { return first_seed + flight % flights; }
};

/// One flight of a campaign.
struct Flown {
  std::size_t number = 0;
  Outcome outcome;
};

/// Flies the share on `jobs` threads; the result does not depend on `jobs`. @throws sim::PhysicsError
/// @param progress called after each flight, by one thread at a time, with the numbers of flights done and of flights
///   that did not stay in control and inside the fence (Outcome::stayed).
std::vector<Flown> fly(const Campaign& campaign, const Share& share, std::size_t jobs,
                       const std::function<void(std::size_t done, std::size_t failed)>& progress);

}  // namespace m100::lab::campaign
