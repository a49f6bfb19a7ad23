// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "firmware/companion/files/excitation_file.h"

namespace m100::companion {

/// The outcome of an excitation, for the result of a flight.
nlohmann::json to_json(const ctl::Excitation<double>& excitation, const ExcitationFile& file);

}  // namespace m100::companion
