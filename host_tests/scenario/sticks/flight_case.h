// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/scenario/sticks/catalogue.h"
#include "host_tests/scenario/sticks/events.h"

namespace m100::sticks {

/// One run of the two programs: which fault, when, on which channel.
struct Case {
  const Fault* fault = nullptr;
  const Fault* second = nullptr;  ///< of a pair, a little later
  Stage stage = Stage::kFlying;
  bool movement = false;
  bool encrypted = false;
  bool real_time = false;
  std::uint64_t seed = 1;
  bool counted = false;  ///< the program counts what its flying thread allocates
  std::string name() const;
};

/// What happened when, on the autopilot's clock; infinity: it did not.
struct Story {
  double pose_taken_away_s = kNever_s;
  double struck_s = kNever_s;
  double struck_again_s = kNever_s;
  double stopped_s = kNever_s;  ///< SIGINT by the operator
  double over_s = 0.0;
  double obtained_s = kNever_s;
  bool ran_until_stopped = false;  ///< the program did not end by itself before
  std::optional<int> ending;       ///< of the program; minus a signal
  bool summed_up = false;
  bool found_another = false;               ///< another autopilot was plugged in, and the link's start-up went through
  std::uint32_t requests_to_the_other = 0;  ///< for control, of an autopilot that nobody meant
  std::string said{};
};

/// What the judge found, seen from the autopilot's end.
struct Verdict {
  bool counted = true;  ///< the program flew before a fault of flight
  std::vector<std::string> violations{};
  double returned_after_s = kNever_s;  ///< from the strike until the transmitter had control; infinity: it never had
  double last_byte_after_loss_s = 0.0;
  double drift_m = 0.0;  ///< from where the aircraft was when the fault struck
};

/// Flies the case. The folder must be empty and is left with what the programs wrote.
Verdict fly(const Case& wanted, const Places& places);

/// Judges by the autopilot's events only; the program's own words count for what it told the operator.
Verdict judge(const Case& flown, const Story& story, const Events& events);

}  // namespace m100::sticks
