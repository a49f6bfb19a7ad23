// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Identifies translation, also vertical if the thrust set point was logged. @throws InputError: missing signal,
/// constant motion, too few blocks, an effect that is unknown or that the log cannot show.
IdentifyResult identify_translation(const Request& request);

}  // namespace m100::lab::identify
