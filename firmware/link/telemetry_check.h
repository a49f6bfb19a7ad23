// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "protocol/telemetry.h"

namespace m100::link {

/// Numbers that are not finite stop here: items that hold one get their former values back and lose their bit in
/// `items`.
/// @returns how many items were refused.
std::uint32_t keep_finite(protocol::Telemetry& telemetry, const protocol::Telemetry& former);

}  // namespace m100::link
