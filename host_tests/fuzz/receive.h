// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::host_tests {

/// Everything that can happen to received bytes: parsed in portions and as the rules say, opened with and without a
/// key, decoded as command, push, telemetry and answer, made again, given to both sides of the sessions.
/// Stops the program (trap) if two ways of doing the same disagree.
void receive_everything(std::span<const std::byte> input);

/// Makes frames out of noise: from back to front, clears the fixed bits behind each start byte and repairs both
/// checksums where a frame fits. @param choice decides, bit by bit, which start bytes are repaired how.
void repair_frames(std::span<std::byte> bytes, std::uint64_t choice);

}  // namespace m100::host_tests
