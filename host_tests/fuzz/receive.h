// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::host_tests {

/// Does everything that the programs do with received bytes: parses them in portions and by the slow reference parser,
/// opens frames with and without a key, decodes commands, pushes, telemetry and answers, encodes them again, and passes
/// them to both sides of the sessions.
/// Stops the program (trap) if two ways of doing the same disagree.
void receive_everything(std::span<const std::byte> input);

/// Makes frames out of random bytes: from back to front, clears the fixed bits after each start byte and repairs both
/// checksums where a frame fits.
/// @param choice decides with two bits per start byte how it is repaired, if at all.
void repair_frames(std::span<std::byte> bytes, std::uint64_t choice);

}  // namespace m100::host_tests
