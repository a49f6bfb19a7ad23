// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/loop/close_loop.h"

namespace m100::lab::loop {

/// Writes a self-contained page: found parameters, predictions and tracking before and after. Errors: InputError.
void write_page(const LoopResult& result, const std::string& file);

}  // namespace m100::lab::loop
