// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/companion/operator/text_line.h"
#include "firmware/ctl/excitation.h"
#include "firmware/link/serial_link.h"
#include "firmware/safety/supervisor.h"

namespace m100::companion {

// Sentences for the operator, with numbers and remedies.

/// The state of the authority table, its reason, and the remedy if there is one.
TextLine describe(const link::AuthorityView& authority);

/// What was seen that is the cause: "pose refused: 0.31 m from the prediction, allowed 0.02 m".
TextLine describe(safety::FailsafeReason cause, const safety::Observation& seen, const safety::Limits& limits);

/// From here on vibration is reported: ten times the sigma that the rotors of a healthy aircraft leave, 0.1 m/s^2 at
/// 100 Hz.
inline constexpr double kReportedVibration_m_s = 0.1;
inline constexpr std::string_view kVibrationRemedy = "check propellers, motors and what is loose";
/// The vibration, and what it hides.
TextLine describe_vibration(const est::VibrationStatus& vibration);

/// A detected limit cycle, the program's reaction, and the remedy.
TextLine describe_limit_cycle(const safety::Observation& seen);

/// The state of an excitation; if aborted, why, with numbers. Nothing if there is none, or while the law returns.
TextLine describe(const ctl::Excitation<double>& excitation);

}  // namespace m100::companion
