// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/battery.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <ostream>
#include <thread>

#include "firmware/companion/files/text/json.h"
#include "host_tests/sim/world/random.h"

namespace m100::authority {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPairs = 120;
constexpr std::uint64_t kPairSeed = 20161114;
// Faults that are also flown in real time: one for each way in which real time, ports and processes matter.
constexpr std::array kInRealTime{"wrong baud rate",
                                 "nothing reaches us",
                                 "nothing of ours arrives for 4 s",
                                 "line cut for 4 s",
                                 "mode switch to A",
                                 "autopilot restarts",
                                 "unplugged for 3 s",
                                 "unplugged for good",
                                 "another autopilot plugged in",
                                 "SIGINT",
                                 "SIGQUIT",
                                 "SIGKILL",
                                 "SIGSEGV",
                                 "SIGSTOP for 3 s",
                                 "pose lost"};

Case case_of(const Fault& fault, Stage stage, bool movement) {
  return {.fault = &fault, .stage = stage, .movement = movement};
}

std::vector<Case> pairs() {
  std::vector<const Fault*> in_flight;
  for (const Fault& fault : catalogue()) {
    if ((fault.stages & bit(Stage::kFlying)) != 0 && !fault.ends_program && !fault.kills_backup &&
        fault.prepare == nullptr) {
      in_flight.push_back(&fault);
    }
  }
  sim::Random random(kPairSeed, "pairs");
  const auto draw = [&] {
    return in_flight[static_cast<std::size_t>(random.uniform() * static_cast<double>(in_flight.size()))];
  };
  std::vector<Case> cases;
  while (cases.size() < kPairs) {
    Case pair{.fault = draw(), .second = draw(), .movement = cases.size() % 2 == 1, .seed = cases.size() + 1};
    if (pair.fault != pair.second) {
      cases.push_back(pair);
    }
  }
  return cases;
}

std::vector<Case> real_time() {
  std::vector<Case> cases;
  for (const Fault& fault : catalogue()) {
    if (std::find(kInRealTime.begin(), kInRealTime.end(), fault.name) != kInRealTime.end()) {
      for (const bool movement : {false, true}) {
        cases.push_back({.fault = &fault, .movement = movement, .real_time = true});
      }
    }
  }
  return cases;
}

Verdict fly_in(const Case& wanted, Places places, const std::string& folder) {
  places.folder = folder;
  fs::create_directories(folder);
  try {
    return fly(wanted, places);
  } catch (const std::exception& failed) {
    return {.counted = false, .violations = {failed.what()}};
  }
}

/// Whether a failure is known: each of its violations matches a line "part of the case's name | part of the violation".
bool is_open(const std::string& name, const Verdict& verdict, const std::vector<std::string>& open) {
  const auto is_listed = [&](const std::string& violation) {
    return std::any_of(open.begin(), open.end(), [&](const std::string& line) {
      const std::size_t bar = line.find(" | ");
      return bar != std::string::npos && name.find(line.substr(0, bar)) != std::string::npos &&
             violation.find(line.substr(bar + 3)) != std::string::npos;
    });
  };
  return !verdict.violations.empty() && std::all_of(verdict.violations.begin(), verdict.violations.end(), is_listed);
}

std::string described(const Result& result) {
  std::array<char, 64> numbers{};
  if (result.verdict.returned_after_s == kNever_s) {
    (void)std::snprintf(numbers.data(), numbers.size(), "transmitter never");
  } else {
    (void)std::snprintf(numbers.data(), numbers.size(), "transmitter after %.3f s", result.verdict.returned_after_s);
  }
  std::string line = result.passed() ? "ok    " : (result.open ? "open  " : "FAIL  ");
  line += result.flown.name() + ": " + numbers.data();
  for (const std::string& violation : result.verdict.violations) {
    line += "; " + violation;
  }
  return line;
}

}  // namespace

std::vector<Case> whole_battery() {
  std::vector<Case> cases;
  for (const Fault& fault : catalogue()) {
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      if ((fault.stages & bit(static_cast<Stage>(stage))) == 0) {
        continue;
      }
      for (const bool movement : {false, true}) {
        cases.push_back(case_of(fault, static_cast<Stage>(stage), movement));
        cases.push_back(cases.back());
        cases.back().encrypted = true;
      }
    }
  }
  for (const std::vector<Case>& more : {pairs(), real_time()}) {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  return cases;
}

std::vector<Case> short_battery() {
  std::vector<Case> cases;
  std::size_t turn = 0;
  for (const Fault& fault : catalogue()) {
    const bool movement = turn % 2 == 1;
    if ((fault.stages & bit(Stage::kFlying)) != 0) {
      cases.push_back(case_of(fault, Stage::kFlying, movement));
    }
    const auto other = static_cast<Stage>(turn % kStages);
    if (other != Stage::kFlying && (fault.stages & bit(other)) != 0) {
      cases.push_back(case_of(fault, other, !movement));
      cases.back().encrypted = turn % 3 == 0;
    }
    ++turn;
  }
  const std::vector<Case> real = real_time();
  for (std::size_t i = 0; i < real.size(); i += 6) {
    cases.push_back(real[i]);
  }
  return cases;
}

std::vector<Case> counted_battery() {
  constexpr std::array kNames{"nothing reaches us",
                              "nothing of ours arrives for 4 s",
                              "bits flipped, 3e-2",
                              "mode switch to A",
                              "autopilot restarts",
                              "Virtual RC ended",
                              "every answer lost",
                              "another autopilot plugged in",
                              "SIGINT",
                              "stall of 0.8 s",
                              "operator presses Enter",
                              "standard input closed",
                              "log may not grow",
                              "pose lost",
                              "pose jumps 1 m"};
  std::vector<Case> cases;
  for (const Fault& fault : catalogue()) {
    if (std::find(kNames.begin(), kNames.end(), fault.name) != kNames.end()) {
      cases.push_back(case_of(fault, Stage::kFlying, cases.size() % 2 == 1));
      cases.back().encrypted = cases.size() % 3 == 0;
      cases.back().counted = true;
    }
  }
  return cases;
}

constexpr int kTriesAgain = 5;  // in real time, where a stall of the machine may end a flight rightly

std::vector<Result> fly_all(const std::vector<Case>& cases, const Places& places, std::size_t jobs,
                            const std::vector<std::string>& open, std::ostream& out) {
  std::vector<Result> results(cases.size());
  std::atomic<std::size_t> next = 0;
  std::mutex writing;
  const auto work = [&] {
    for (std::size_t i = next++; i < cases.size(); i = next++) {
      const std::string folder = places.folder + "/" + std::to_string(i);
      results[i] = {.flown = cases[i], .verdict = fly_in(cases[i], places, folder)};
      // A case counts only if the program flew before the fault; a busy machine may have ended the flight earlier.
      for (int more = 0; more < kTriesAgain && cases[i].real_time && !results[i].verdict.counted; ++more) {
        fs::remove_all(folder);
        results[i].verdict = fly_in(cases[i], places, folder);
      }
      results[i].open = is_open(cases[i].name(), results[i].verdict, open);
      if (results[i].passed() && !places.keep) {
        fs::remove_all(folder);
      }
      const std::lock_guard lock(writing);
      out << i << " " << described(results[i]) << std::endl;
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t job = 0; job < jobs; ++job) {
    threads.emplace_back(work);
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  return results;
}

namespace {

struct Cell {
  std::size_t flown = 0;
  std::size_t failed = 0;
  double slowest_s = 0.0;
  double last_byte_s = 0.0;
};

std::string text_of(const Cell& cell) {
  const char* const mark = cell.failed > 0 ? " (!)" : "";
  std::array<char, 64> words{};
  if (cell.flown == 0) {
    words = {" |"};
  } else if (cell.slowest_s == kNever_s) {
    (void)std::snprintf(words.data(), words.size(), " never%s |", mark);
  } else if (cell.last_byte_s > 0.0) {
    (void)std::snprintf(words.data(), words.size(), " %.2f, %.0f ms%s |", cell.slowest_s, 1e3 * cell.last_byte_s, mark);
  } else {
    (void)std::snprintf(words.data(), words.size(), " %.2f%s |", cell.slowest_s, mark);
  }
  return words.data();
}

}  // namespace

std::string matrix(const std::vector<Result>& results) {
  std::map<std::string_view, std::array<Cell, kStages>> cells;
  for (const Result& result : results) {
    if (result.flown.second != nullptr) {
      continue;
    }
    Cell& cell = cells[result.flown.fault->name][static_cast<std::size_t>(result.flown.stage)];
    ++cell.flown;
    cell.failed += result.passed() ? 0U : 1U;
    cell.slowest_s = std::max(cell.slowest_s, result.verdict.returned_after_s);
    cell.last_byte_s = std::max(cell.last_byte_s, result.verdict.last_byte_after_loss_s);
  }
  std::string text = "| fault: after [s] |";
  for (const std::string_view stage : kStageNames) {
    text += " " + std::string(stage) + " |";
  }
  text += "\n|---|---|---|---|---|---|---|---|\n";
  for (const Fault& fault : catalogue()) {
    const auto row = cells.find(fault.name);
    if (row == cells.end()) {
      continue;
    }
    text += "| " + std::string(fault.name) + " |";
    for (const Cell& cell : row->second) {
      text += text_of(cell);
    }
    text += "\n";
  }
  return text;
}

std::string to_json(const std::vector<Result>& results) {
  Json cases = Json::array();
  for (const Result& result : results) {
    const Case& flown = result.flown;
    Json one{{"fault", flown.fault->name},
             {"stage", kStageNames[static_cast<std::size_t>(flown.stage)]},
             {"group", kGroupNames[static_cast<std::size_t>(flown.fault->group)]},
             {"channel", flown.movement ? "movement" : "virtual_rc"},
             {"encrypted", flown.encrypted},
             {"real_time", flown.real_time},
             {"seed", flown.seed},
             {"passed", result.passed()},
             {"open", result.open},
             {"counted", result.verdict.counted},
             {"violations", result.verdict.violations},
             {"last_byte_after_loss_s", result.verdict.last_byte_after_loss_s},
             {"drift_m", result.verdict.drift_m}};
    one["second"] = flown.second != nullptr ? Json(flown.second->name) : Json();
    one["transmitter_after_s"] =
        result.verdict.returned_after_s == kNever_s ? Json() : Json(result.verdict.returned_after_s);
    cases.push_back(std::move(one));
  }
  const auto count = [&](auto&& condition) { return std::count_if(results.begin(), results.end(), condition); };
  return Json{{"cases", cases},
              {"flown", results.size()},
              {"passed", count([](const Result& r) { return r.passed(); })},
              {"open", count([](const Result& r) { return r.open && !r.passed(); })}}
      .sorted()
      .dump(1);
}

}  // namespace m100::authority
