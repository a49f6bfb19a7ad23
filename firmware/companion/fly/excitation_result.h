// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/text/json.h"

namespace m100::companion {

/// The outcome of an excitation, for the result of a flight.
Json to_json(const ctl::Excitation<double>& excitation, const ExcitationFile& file);

}  // namespace m100::companion
