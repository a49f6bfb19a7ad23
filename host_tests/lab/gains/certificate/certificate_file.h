// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "firmware/companion/files/mode.h"
#include "host_tests/lab/gains/certificate/certify.h"

namespace m100::lab::gains {

/// The text of the certificate file, which firmware/companion/fly/margin_certificate.h reads.
/// @param table bytes of the gain table file; empty: none was made
std::string certificate_text(const companion::VehicleFile& file, companion::Mode mode, const std::string& table,
                             const std::vector<CertifiedLoop>& loops, double margin);

}  // namespace m100::lab::gains
