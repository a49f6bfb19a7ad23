// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/hidden/hidden_flight.h"

namespace m100::lab::hidden {

/// An effect's number at `size` 0 small, 1 medium, 2 large. The seed varies its size by +-15 %, and the sign of some.
double size_of(const std::string& effect, int size, std::uint64_t seed);
/// Whether this vehicle can have the effect.
bool supports_effect(const std::string& effect);

}  // namespace m100::lab::hidden
