// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/scenario/authority/catalogue.h"
#include "host_tests/scenario/authority/events.h"

namespace m100::authority {

/// One run of the two programs: the fault, its time, the channel.
struct Case {
  const Fault* fault = nullptr;
  const Fault* second = nullptr;  ///< second fault of a pair, a little later
  Stage stage = Stage::kFlying;
  bool movement = false;
  bool encrypted = false;
  bool real_time = false;
  std::uint64_t seed = 1;
  bool counted = false;  ///< the program counts the allocations of its flying thread
  std::string name() const;
};

/// Times of events, on the autopilot's clock; infinity if it did not happen.
struct FlightTimes {
  double pose_taken_away_s = kNever_s;
  double struck_s = kNever_s;
  double struck_again_s = kNever_s;
  double stopped_s = kNever_s;  ///< the operator's SIGINT
  double over_s = 0.0;
  double obtained_s = kNever_s;
  bool ran_until_stopped = false;  ///< the program did not end by itself before
  std::optional<int> ending;       ///< exit code of the program, or minus the signal
  bool summed_up = false;
  bool found_another = false;               ///< another autopilot was plugged in, and the link's start-up succeeded
  std::uint32_t requests_to_the_other = 0;  ///< requests for control to the wrong autopilot
  std::string said{};
};

/// The judge's result, from the events at the autopilot.
struct Verdict {
  bool counted = true;  ///< false: the program did not fly before a fault in flight
  std::vector<std::string> violations{};
  double returned_after_s = kNever_s;  ///< from the strike until the transmitter had control; infinity if it never had
  double last_byte_after_loss_s = 0.0;
  double drift_m = 0.0;  ///< from where the aircraft was when the fault struck
};

/// Flies the case. The folder must be empty; afterwards it holds the programs' files.
Verdict fly(const Case& wanted, const Places& places);

/// Judges by the autopilot's events; the program's own output is used only for the messages to the operator.
Verdict judge(const Case& flown, const FlightTimes& times, const Events& events);

}  // namespace m100::authority
