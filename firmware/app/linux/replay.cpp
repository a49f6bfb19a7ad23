// SPDX-License-Identifier: BSD-3-Clause
// m100 replay: the same bytes at the same times through the same code.
#include "firmware/app/replay.h"

#include <iostream>
#include <memory>
#include <optional>

#include "firmware/app/linux/key_file.h"
#include "firmware/app/linux/subcommands.h"
#include "protocol/aes256.h"

namespace m100::app {
namespace {

struct Options {
  std::string log;
  std::string scalar = "double";
  std::string key_file;
  bool hash_only = false;
};

void run(const Options& options) {
  const Scalar scalar = options.scalar == "float"   ? Scalar::kFloat
                        : options.scalar == "fixed" ? Scalar::kFixed
                                                    : Scalar::kDouble;
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(read_key(options.key_file));
  }
  const RecordedFlight flight = read_flight(options.log);
  if (flight.ticks.empty()) {
    throw UsageError(options.log + ": holds no complete tick");
  }
  const ReplayResult result = [&] {
    try {
      return replay(flight, scalar, cipher ? &*cipher : nullptr);
    } catch (const FlightLogError& wrong) {
      throw UsageError(options.log + ": " + wrong.what());
    }
  }();
  const auto digits = core::hex(result.digest);
  std::cout << std::string(digits.data(), digits.size()) << "\n";
  if (!options.hash_only) {
    std::cout << result.ticks << " ticks in " << options.scalar << ", " << result.ticks_unlike << " unlike the record";
    if (result.ticks_unlike > 0) {
      std::cout << " (the first is " << result.first_unlike << ")";
    }
    if (result.messages_missing > 0) {
      std::cout << "; the log lacks " << result.messages_missing << " messages";
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
  app->add_option("--key-file", options->key_file, "file with the app's key, for a flight with encrypted commands");
  app->add_flag("--hash", options->hash_only, "print the SHA-256 over output bytes and state records only");
  app->callback([options] { run(*options); });
}

}  // namespace m100::app
