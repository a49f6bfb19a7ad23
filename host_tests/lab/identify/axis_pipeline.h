// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Identifies a stick axis. @throws InputError: missing signal, axis never moved, too few blocks, unknown effect.
IdentifyResult identify_axis(const Request& request);

}  // namespace m100::lab::identify
