// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "protocol/dji/telemetry.h"

namespace m100::link {

/// Removes numbers that are not finite: an item that holds one gets all its values of `former` and loses its bit in
/// `items`.
/// @returns how many items were refused.
std::uint32_t reject_non_finite(protocol::Telemetry& telemetry, const protocol::Telemetry& former);

}  // namespace m100::link
