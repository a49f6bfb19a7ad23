// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "firmware/companion/preflight/check_result.h"
#include "firmware/companion/preflight/probe/line_probe.h"
#include "firmware/link/link_health.h"

namespace m100::companion {

/// What listening to one port at one baud rate has shown.
struct PortVerdict {
  std::string port;
  std::uint32_t baud = 0;
  Verdict verdict = Verdict::kCannotOpen;
  Firmware firmware = Firmware::kUnknown;
  link::LinkHealth health{};
  core::Expected<hal::LineErrors> errors = core::Status::kUnavailable;

  bool has_autopilot() const { return verdict == Verdict::kAutopilot || verdict == Verdict::kNoisy; }
};

/// Listens to a port; sends nothing.
PortVerdict listen(const std::string& port, std::uint32_t baud, double seconds);

/// The best verdict over the ports, and over every rate that DJI supports if `baud` is 0. Prints each as it comes.
PortVerdict search_line(const std::vector<std::string>& ports, std::uint32_t baud, double seconds);

/// What to do; for a port that cannot be opened, finding and remedy of preflight::check_port().
std::string remedy_of(const PortVerdict& found);
Json to_json(const PortVerdict& found);
/// Rate and verdict; of an autopilot also its firmware.
std::string describe(const PortVerdict& found);

/// Reads what has arrived. @returns whether telemetry with attitude and specific force is known, and some has come.
bool receive_telemetry(hal::Uart& port, LineProbe& line);
/// What is missing where receive_telemetry() never returned true. @param name of the check
preflight::CheckResult missing_telemetry(const LineProbe& line, const char* name, preflight::Health health);

namespace preflight {

/// Listens to the autopilot for four seconds and measures the vibration (est::Vibration) as a flight does, with the
/// rotors as they turn meanwhile. kDoubtful: it would be reported in flight, or it could not be measured.
CheckResult check_vibration(const std::string& port, std::uint32_t baud);

}  // namespace preflight

}  // namespace m100::companion
