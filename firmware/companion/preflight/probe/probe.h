// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/subcommands.h"

namespace m100::companion {

void add_probe(CLI::App& m100);

}  // namespace m100::companion
