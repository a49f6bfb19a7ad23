// SPDX-License-Identifier: BSD-3-Clause
// m100 replay: feeds the same bytes at the same times through the same code.
#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/replay/replay.h"

#include <iostream>
#include <optional>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/subcommands.h"
#include "protocol/aes256.h"

namespace m100::companion {
namespace {

struct ReplayOptions {
  std::string log;
  std::string scalar = "double";
  std::string key_file;
  bool hash_only = false;
  std::string json;
};

/// The first runs of differing ticks: "tick 17 to 19, 40 (4 in all, counted from 0)".
std::string unlike_text(const ReplayResult& result) {
  constexpr std::size_t kRuns = 5;
  std::string text;
  std::size_t runs = 0;
  for (std::size_t i = 0; i < result.differences.size() && runs < kRuns; ++runs) {
    std::size_t last = i;
    while (last + 1 < result.differences.size() && result.differences[last + 1] == result.differences[last] + 1) {
      ++last;
    }
    text += (text.empty() ? "tick " : ", ") + std::to_string(result.differences[i]);
    text += last > i ? " to " + std::to_string(result.differences[last]) : "";
    i = last + 1;
  }
  return text + " (" + std::to_string(result.differences.size()) + " in all, counted from 0)";
}

Json to_json(const ReplayOptions& options, const ReplayResult& result, const std::string& digest, bool is_same) {
  return {{"log", options.log},
          {"scalar", options.scalar},
          {"sha256", digest},
          {"same", is_same},
          {"ticks", result.ticks},
          {"ticks_unlike", result.different_ticks},
          {"unlike", result.differences},
          {"messages_missing", result.messages_missing},
          {"largest_difference_m", result.largest_difference_m},
          {"largest_command_difference_rad", result.largest_command_difference_rad}};
}

void print(const ReplayOptions& options, const ReplayResult& result) {
  std::cout << result.ticks << " ticks in " << options.scalar << ", " << result.different_ticks
            << " differ from the log";
  if (result.different_ticks > 0) {
    std::cout << " (the first is " << result.first_difference << ")";
  }
  if (result.messages_missing > 0) {
    std::cout << "; the log lacks " << result.messages_missing << " messages";
  }
  std::cout << "; largest difference " << result.largest_difference_m << " m, command "
            << result.largest_command_difference_rad << " rad\n";
}

void run(const ReplayOptions& options) {
  FileUse().reads("log", options.log).reads("--key-file", options.key_file).writes("--json", options.json).check();
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
    } catch (const std::runtime_error& wrong) {  // also errors of the notes: vehicle file, course, flight file
      throw UsageError(options.log + ": " + wrong.what());
    }
  }();
  const bool judged = scalar == Scalar::kDouble;  // as in `m100 fly`; in other arithmetic, differences are expected
  const auto digits = core::hex(result.digest);
  const std::string digest(digits.data(), digits.size());
  std::cout << digest << "\n";
  if (!options.hash_only) {
    print(options, result);
  }
  if (!options.json.empty()) {
    write_json(options.json, to_json(options, result, digest, result.different_ticks == 0));
  }
  if (judged && result.different_ticks > 0) {
    std::cerr << "m100: " << printable(options.log) << ": the replay differs from the log: " << unlike_text(result)
              << "\n";
    throw AnswerIsNo();
  }
}

}  // namespace

void add_replay(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<ReplayOptions>(
      "replay", "feed a flight log's bytes and times through the flight code again", run);
  app.add_option("log", options->log, "flight log (ULog) of this program").required();
  app.add_option("--scalar", options->scalar, "arithmetic of the replay").one_of({"double", "float", "fixed"});
  app.add_option("--key-file", options->key_file, "file with the app's key, for a flight with encrypted commands");
  app.add_flag("--hash", options->hash_only, "print only the SHA-256 over output bytes and state records");
  app.add_option("--json", options->json, "hash, ticks and differences as JSON");
}

}  // namespace m100::companion
