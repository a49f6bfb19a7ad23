// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "host_tests/sim/plant.h"

namespace m100::sim {

/// What is wrong with a plant file, in one line: "p.toml:3: 'air.wnid_m_s': unknown key".
class PlantFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a plant file (TOML). The axes have the keys, ranges and orders of the vehicle file. A section that is missing
/// is as in measured_plant(); in an axis section a missing key is an effect that is absent, in every other section it
/// keeps its measured value. Unknown sections and keys, wrong types and values out of range are errors.
Plant load_plant(const std::string& path);
/// The same from text; `name` stands for the file in messages.
Plant parse_plant(std::string_view text, const std::string& name);

}  // namespace m100::sim
