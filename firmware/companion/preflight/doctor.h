// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/subcommands.h"

namespace m100::companion {

void add_doctor(CLI::App& m100);
void add_probe(CLI::App& m100);  ///< another word for what doctor --port tells of the line

}  // namespace m100::companion
