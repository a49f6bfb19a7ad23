// SPDX-License-Identifier: BSD-3-Clause
// Searches, channel by channel, for the fault that moves the aircraft farthest before it is noticed.
#include <cstdio>
#include <exception>

#include "firmware/companion/command_line.h"
#include "host_tests/scenario/sensor_faults/recorded_faults.h"

namespace m100::scenario {
namespace {

/// @returns whether no worse fault was found than the kept one.
bool search_one(const Channel& channel, int flights, std::uint64_t seed, const RecordedFault& recorded) {
  const SearchResult found = run_search(channel, flights, seed, recorded.fault);
  const double score_m = score_of(channel, found.effect);
  const bool kept_is_worst = score_m <= recorded.limit_m;
  std::printf(
      "%s%s | %.2f | %s\n    noticed after %.1f s, %.2f m away; %.2f m when the pilot has control, at %.2f m/s\n",
      kept_is_worst ? "" : "WORSE THAN KEPT ", std::string(channel.name).c_str(), score_m, to_text(found.fault).c_str(),
      found.effect.after_s, found.effect.away_m, found.effect.farthest_m, found.effect.speed_m_s);
  static_cast<void>(std::fflush(stdout));
  return kept_is_worst;
}

int run(int argc, char** argv) {
  std::string only, kept_file;
  int flights = 300;
  std::uint64_t seed = 15;
  companion::CommandLine app(
      "Searches for the fault of one channel that moves the aircraft farthest before it is noticed. Exit code "
      "1: a fault was found that is worse than the kept one.");
  app.show_defaults();
  app.add_option("--channel", only, "Only this channel (default: all)");
  app.add_option("--flights", flights, "Flights for each channel").positive();
  app.add_option("--seed", seed, "Seed of the search");
  app.add_option("--kept", kept_file, "File of the worst faults found so far; the search starts from them")
      .existing_file();
  app.read(argc, argv);
  const auto recorded =
      kept_file.empty() ? std::map<std::string, RecordedFault, std::less<>>() : recorded_faults(kept_file);
  bool sound = true;
  for (const Channel& channel : channels()) {
    if (only.empty() || channel.name == only) {
      const auto found = recorded.find(channel.name);
      sound = search_one(channel, flights, seed,
                         found == recorded.end() ? RecordedFault{.fault = {}, .limit_m = FaultEffect::kNever}
                                                 : found->second) &&
              sound;
    }
  }
  return sound ? 0 : 1;
}

}  // namespace
}  // namespace m100::scenario

int main(int argc, char** argv) {
  try {
    return m100::scenario::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lie_search: %s\n", error.what());
    return 2;
  }
}
