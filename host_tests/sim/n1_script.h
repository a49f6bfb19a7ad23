// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/core/time.h"

namespace m100::sim {

/// Things that happen to the emulated autopilot at stated times.
enum class N1Happening : std::uint8_t {
  kMode,          ///< value: 'F', 'A' or 'P' of the real mode switch
  kRc,            ///< 1 on, 0 off: the remote controller
  kTake,          ///< 'm' the mobile app takes control, 'r' it (or the pilot) ends that and the RC has it
  kRestart,       ///< the autopilot reboots: everything forgotten, silent for two seconds
  kSilence,       ///< seconds without telemetry
  kLoseAcks,      ///< the next n acknowledgements are lost
  kDelayAcks,     ///< seconds by which acknowledgements are late from now on; 0 ends it
  kDoubleAcks,    ///< the next n acknowledgements are sent twice
  kNoise,         ///< bytes of noise towards the client
  kLoss,          ///< share of frames lost, both ways, from now on
  kIoc,           ///< 1 on, 0 off: IOC mode
  kActivation,    ///< activation is answered with this code from now on
  kEndVirtualRc,  ///< Virtual RC ends without a reason given
};

struct N1ScriptLine {
  core::TimePoint at{};
  N1Happening what = N1Happening::kMode;
  double value = 0.0;
};

/// A line of a script that cannot be read: its number and what is wrong with it.
class N1ScriptError : public std::runtime_error {
 public:
  N1ScriptError(long line, const std::string& what) : std::runtime_error(what), line_(line) {}
  long line() const { return line_; }

 private:
  long line_;
};

/// Reads a script. One happening per line, `#` begins a comment, times in seconds and not falling:
///
///   12.5 mode A | F | P        20 take mobile | rc      25 restart            30 silence 0.6
///   30 lose_acks 2             30 delay_acks 0.3        30 double_acks 2      30 noise 200
///   30 loss 0.01               30 ioc on | off          30 rc on | off        0 activation 3
///   40 end_virtual_rc
///
/// @throws N1ScriptError
std::vector<N1ScriptLine> read_n1_script(const std::string& text);

}  // namespace m100::sim
