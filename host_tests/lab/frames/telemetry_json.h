// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/json.h"
#include "protocol/dji/telemetry.h"

namespace m100::lab {

/// The items of a telemetry package, under the names used in the recorded vectors.
Json telemetry_fields(const protocol::Telemetry& telemetry);

}  // namespace m100::lab
