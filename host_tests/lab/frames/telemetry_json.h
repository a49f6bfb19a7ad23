// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "protocol/dji/telemetry.h"

namespace m100::lab {

/// The items of a telemetry package, under the names used in the recorded vectors.
nlohmann::ordered_json telemetry_fields(const protocol::Telemetry& telemetry);

}  // namespace m100::lab
