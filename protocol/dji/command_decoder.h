// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "protocol/dji/commands.h"

namespace m100::protocol {

/// Decodes a command as the flight controller receives it. Sizes must fit exactly and enumerators must exist, but
/// an unknown Rate is read as kAsItIs. Numbers and the movement flag are not checked: the receiver handles a NaN.
/// @returns kInvalidArgument: unknown id, wrong size or an impossible code.
core::Expected<Command> decode_command(MessageId id, std::span<const std::byte> value);

}  // namespace m100::protocol
