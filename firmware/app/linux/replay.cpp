// SPDX-License-Identifier: BSD-3-Clause
// m100 replay: the same bytes at the same times through the same code.
#include "firmware/app/replay.h"

#include <iostream>
#include <memory>

#include "firmware/app/linux/subcommands.h"

namespace m100::app {
namespace {

struct Options {
  std::string log;
  std::string scalar = "double";
  bool hash_only = false;
};

void run(const Options& options) {
  const Scalar scalar = options.scalar == "float"   ? Scalar::kFloat
                        : options.scalar == "fixed" ? Scalar::kFixed
                                                    : Scalar::kDouble;
  const ReplayResult result = replay(read_flight(options.log), scalar);
  const auto digits = core::hex(result.digest);
  std::cout << std::string(digits.data(), digits.size()) << "\n";
  if (!options.hash_only) {
    std::cout << result.ticks << " ticks in " << options.scalar << ", " << result.ticks_unlike << " unlike the record";
    if (result.ticks_unlike > 0) {
      std::cout << " (the first is " << result.first_unlike << ")";
    }
    std::cout << "; largest difference " << result.largest_difference_m << " m, command "
              << result.largest_command_difference_rad << " rad\n";
  }
}

}  // namespace

void add_replay(CLI::App& m100) {
  CLI::App* app = m100.add_subcommand("replay", "feed a flight log's bytes and times through the flight code again");
  auto options = std::make_shared<Options>();
  app->add_option("log", options->log, "flight log (ULog) of this program")->required();
  app->add_option("--scalar", options->scalar, "arithmetic to fly in")
      ->check(CLI::IsMember({"double", "float", "fixed"}));
  app->add_flag("--hash", options->hash_only, "print the SHA-256 over output bytes and state records only");
  app->callback([options] { run(*options); });
}

}  // namespace m100::app
