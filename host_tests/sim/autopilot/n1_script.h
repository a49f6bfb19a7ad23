// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_pilot.h"
#include "host_tests/sim/sensor_faults/sensor_fault_injector.h"
#include "protocol/dji/catalogue.h"

namespace m100::sim {

/// Scripted events of the emulated autopilot, at stated times.
enum class N1EventKind : std::uint8_t {
  kMode,          ///< value: 'F', 'A' or 'P' of the real mode switch
  kRc,            ///< 1 on, 0 off: the remote controller
  kTake,          ///< 'm': the mobile app takes control; 'r': the app (or the pilot) ends that, and the RC has control
  kRestart,       ///< the autopilot reboots: its state is lost, and it is silent for two seconds
  kSilence,       ///< seconds without telemetry
  kLoseAcks,      ///< the next n acknowledgements are lost; if a command is named, only those of that command
  kDelayAcks,     ///< seconds by which acknowledgements are late from now on; 0 ends it
  kDoubleAcks,    ///< the next n acknowledgements are sent twice
  kNoise,         ///< bytes of noise towards the client
  kLoss,          ///< share of frames lost, both ways, from now on
  kIoc,           ///< 1 on, 0 off: IOC mode
  kActivation,    ///< activation is answered with this code from now on
  kEndVirtualRc,  ///< Virtual RC ends without a reason given
  kTasks,    ///< take-off and landing, from now on: 0 refused; 2 accepted, not begun; 3 begun, never ended; 1 normal
  kEndTask,  ///< the autopilot aborts its take-off or landing
  kPose,     ///< 0: the source sends no poses from now on; 1: it sends them again
  kStick,    ///< the pilot moves a stick
  kSensorFault,  ///< telemetry, or the poses, are false from now on
};

/// Commands whose acknowledgements can be lost by name.
enum class N1Request : std::uint8_t {
  kAny,
  kVersion,
  kActivate,
  kSetRates,
  kObtainControl,
  kReleaseControl,
  kMotors,
  kTask,
  kTaskQuery,
};
struct N1RequestName {
  std::string_view text;  ///< in a script
  N1Request request;
  protocol::MessageId id;
};
inline constexpr std::array kN1RequestNames{
    N1RequestName{"version_query", N1Request::kVersion, protocol::ids::kVersionQuery},
    N1RequestName{"activate", N1Request::kActivate, protocol::ids::kActivation},
    N1RequestName{"set_broadcast_frequency", N1Request::kSetRates, protocol::ids::kTelemetryFrequency},
    N1RequestName{"obtain_control", N1Request::kObtainControl, protocol::ids::kControlRequest},
    N1RequestName{"release_control", N1Request::kReleaseControl, protocol::ids::kControlRequest},
    N1RequestName{"motors", N1Request::kMotors, protocol::ids::kMotors},
    N1RequestName{"task", N1Request::kTask, protocol::ids::kTask},
    N1RequestName{"task_query", N1Request::kTaskQuery, protocol::ids::kTaskQuery},
};

struct N1ScriptLine {
  core::TimePoint at{};
  N1EventKind what = N1EventKind::kMode;
  double value = 0.0;
  N1Request request = N1Request::kAny;  ///< of kLoseAcks
  N1StickMove move{};                   ///< of kStick
  const SensorFault* fault = nullptr;   ///< of kSensorFault; `value` is its size
};

/// An invalid line of a script: its number and the error.
class N1ScriptError : public std::runtime_error {
 public:
  N1ScriptError(long line, const std::string& what) : std::runtime_error(what), line_(line) {}
  long line() const { return line_; }

 private:
  long line_;
};

/// Reads a script. One event per line, `#` begins a comment, times in seconds, never decreasing:
///
///   12.5 mode A | F | P        20 take mobile | rc      25 restart            30 silence 0.6
///   30 lose_acks 2 [obtain_control]                     30 delay_acks 0.3     30 double_acks 2    30 noise 200
///   30 loss 0.01               30 ioc on | off          30 rc on | off        0 activation 3
///   40 end_virtual_rc         40 tasks off | stuck | endless | on
///   40 end_task               40 pose off | on
///
/// the pilot's movements of roll, pitch, throttle or yaw while he has control (counts from the resting position;
/// positive: right, forward, up, right):
///
///   50 stick roll 120 0.5              120 counts for 0.5 s
///   52 doublet pitch 150 0.4           0.4 s to one side, 0.4 s to the other
///   55 3211 roll 150 0.3               3, 2, 1, 1 times 0.3 s, to either side in turn
///   60 chirp roll 100 0.4 2.5 8        a sine from 0.4 to 2.5 Hz within 8 s
///
/// and a sensor fault of a channel by its name (sensor_fault_injector.h), with a size if it differs from the default:
///
///   30 fault standing                    30 fault drift 0.1
///
/// @throws N1ScriptError
std::vector<N1ScriptLine> read_n1_script(const std::string& text);

}  // namespace m100::sim
