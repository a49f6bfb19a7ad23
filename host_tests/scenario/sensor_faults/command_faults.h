// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/sim/world/random.h"

namespace m100::scenario {

/// Events that may happen in the channels that carry orders and answers instead of numbers.
enum class CommandFaultKind : std::uint8_t {
  kEngage,        ///< the operator orders to fly
  kRelease,       ///< the operator orders to stop
  kLoseAcks,      ///< the next `value` answers of the autopilot are lost
  kDoubleAcks,    ///< the next `value` answers are sent twice
  kDelayAcks,     ///< answers are late by `value` seconds from then
  kReportsOurs,   ///< for `value` seconds telemetry says that we have control
  kReportsPilot,  ///< for `value` seconds telemetry says that the transmitter has it
  kReportsMode,   ///< for `value` seconds telemetry says that the mode switch is not at F
};
inline constexpr std::array<std::string_view, 8> kCommandFaultNames{
    "engage", "release", "lose_acks", "double_acks", "delay_acks", "says_ours", "says_pilots", "says_mode"};
/// The first kOperatorWords words are the operator's, the others the autopilot's.
inline constexpr std::size_t kOperatorWords = 2;

struct CommandFault {
  CommandFaultKind kind = CommandFaultKind::kEngage;
  double at_s = 0.0;   ///< from the beginning of the course
  double value = 0.0;  ///< a count or seconds, depending on the word
};
using CommandFaults = std::vector<CommandFault>;

/// Text form: "release 3.2 0; engage 3.9 0". @throws std::invalid_argument for a malformed text.
std::string to_text(const CommandFaults& command_faults);
CommandFaults command_faults_of(const std::string& text);

/// Draws one to six happenings of the operator or of the autopilot.
CommandFaults drawn_command_faults(bool operators, double within_s, sim::Random& random);
CommandFaults neighbour_of(const CommandFaults& command_faults, bool operators, double within_s, sim::Random& random);

}  // namespace m100::scenario
