// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Identifies horizontal translation. @throws InputError as above.
IdentifyResult identify_translation(const Request& request);

}  // namespace m100::lab::identify
