// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/safety/failsafe.h"
#include "firmware/safety/limits.h"
#include "firmware/safety/observation.h"

namespace m100::companion {

/// What prevents flying now, apart from authority and orders; kNone: nothing.
safety::FailsafeReason denial_reason(const safety::Observation& seen, const safety::Limits& limits);
/// The remedy for an obstacle.
std::string_view remedy_for(safety::FailsafeReason denial_reason);

}  // namespace m100::companion
