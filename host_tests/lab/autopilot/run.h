// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/body/body_choice.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::autopilot {

inline constexpr std::string_view kLiveScript = "-";

struct Options {
  std::string pty;
  std::string pose_pty;
  std::string simulated;
  std::string board;
  std::string course = "hover";
  std::string plant;
  std::string plant_from;
  std::uint64_t seed = 1;
  std::string mode = "F";
  std::string real;    ///< file of what was seen on a real autopilot
  std::string script;  ///< file; kLiveScript: lines are typed in during the run
  std::string events;
  std::uint32_t baud = 230400;
  std::uint32_t app_id = 0;
  std::string key_file;
  double loss = 0.0;
  double duration_s = 0.0;
  bool lenient_virtual_rc = false;
  bool on_ground = false;  ///< motors stopped
  sim::BodyChoice body;
};

/// Whether SIGINT or SIGTERM has arrived, so that the program must write its summary and end.
bool stop_requested();

}  // namespace m100::lab::autopilot
