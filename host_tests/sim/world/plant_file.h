// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "firmware/companion/files/text/file_error.h"
#include "host_tests/sim/world/plant.h"

namespace m100::sim {

/// Reads a plant file (TOML): a list of differences from `base`. A missing section or key keeps the value of `base`; a
/// file of comments alone is the base itself. The axes have the keys and ranges of the vehicle file; zero switches an
/// effect off. A time constant replaces the second order of an axis, a natural frequency its first, with a damping of 1
/// if none is given and none was measured. Unknown sections and keys, wrong types and values out of range are errors:
/// companion::FileError.
Plant load_plant(const std::string& path, const Plant& base = measured_plant());
/// The same from text; `name` stands for the file in messages.
Plant parse_plant(std::string_view text, const std::string& name, const Plant& base = measured_plant());

}  // namespace m100::sim
