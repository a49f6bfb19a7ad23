// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/companion/fly/text_line.h"
#include "firmware/ctl/excitation.h"
#include "firmware/link/serial_link.h"
#include "firmware/safety/supervisor.h"

namespace m100::companion {

// What the operator reads, with numbers and with what to do.

/// Where the authority table stands, why, and the remedy where there is one.
void describe(TextLine& line, const link::AuthorityView& authority);

/// What was seen: "pose refused: 0.31 m from where it must be, allowed 0.02 m".
void describe(TextLine& line, safety::Cause cause, const safety::Observation& seen, const safety::Limits& limits);

/// A swing that was noticed, what is done about it, and what to do; Observation::swings.
void describe_swing(TextLine& line, const safety::Observation& seen);

/// Where an excitation stands; why it was aborted, with numbers. Nothing where there is none.
void describe(TextLine& line, const ctl::Excitation<double>& excitation);

/// What stands in the way of flying now; kNone: nothing.
safety::Cause obstacle(const safety::Observation& seen, const safety::Limits& limits);
/// What to do about it.
std::string_view what_helps(safety::Cause obstacle);

}  // namespace m100::companion
