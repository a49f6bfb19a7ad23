// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "host_tests/sim/world/plant.h"

namespace m100::sim {

/// The error of a plant file in one line, such as "p.toml:3: 'air.wnid_m_s': unknown key".
class PlantFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a plant file (TOML): a list of differences from `base`. A missing section or key keeps the value of `base`; a
/// file of comments alone is the base itself. The axes have the keys and ranges of the vehicle file; zero switches an
/// effect off. A time constant replaces the second order of an axis, a natural frequency its first, with a damping of 1
/// if none is given and none was measured. Unknown sections and keys, wrong types and values out of range are errors.
Plant load_plant(const std::string& path, const Plant& base = measured_plant());
/// The same from text; `name` stands for the file in messages.
Plant parse_plant(std::string_view text, const std::string& name, const Plant& base = measured_plant());

}  // namespace m100::sim
