// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host_tests/lab/campaign/outcome.h"

namespace m100::lab::campaign {

/// A plant file, and the name under which it stands in tables.
struct World {
  std::string name;    ///< of the file without folder and .toml
  std::string path;    ///< as given
  std::string digest;  ///< of the file's bytes, in hexadecimal
  sim::Plant plant;
};

/// Which part of all flights: number `part` of `parts`, counted from 1. Flight i belongs to part i % parts + 1.
struct Share {
  std::size_t part = 1;
  std::size_t parts = 1;
};

/// A campaign: worlds x tasks x seeds. Flights are numbered in this order, seeds the fastest.
struct Campaign {
  std::vector<World> worlds;
  std::vector<Task> tasks;
  std::uint64_t first_seed = 1;
  std::size_t flights = 10;  ///< of each task in each world
  Settings settings;
  std::vector<std::string> options{};  ///< words that repeat the settings on the command line

  std::size_t size() const { return worlds.size() * tasks.size() * flights; }
};

/// One flight of a campaign.
struct Flown {
  std::size_t number = 0;
  Outcome outcome;
};

/// Flies the share on so many threads. The answer does not depend on how many there are.
/// @param progress called now and then, from one thread at a time, with how many flights are done and have not stayed.
std::vector<Flown> fly(const Campaign& campaign, const Share& share, std::size_t jobs,
                       const std::function<void(std::size_t done, std::size_t failed)>& progress);

/// Everything that a report says, as JSON: "worlds" as the contract has it, "campaign" with the settings, and "flown"
/// with each flight, from which the rest follows. "part" stands there only where it is not the whole.
nlohmann::ordered_json to_json(const Campaign& campaign, const Share& share, const std::vector<Flown>& flown);

/// One campaign out of its parts: byte for byte the JSON that one process would have written. Errors: InputError, where
/// a file is no part of a campaign, parts are of different campaigns, or flights stand twice or nowhere.
nlohmann::ordered_json merged(const std::vector<std::string>& paths);

/// Whether every flight of a report stayed.
bool all_stayed(const nlohmann::ordered_json& report);

}  // namespace m100::lab::campaign
