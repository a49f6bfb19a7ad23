// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

namespace m100::lab::campaign {

/// A report (to_json, merged) as a table for people, and the failures with the command that repeats each.
void print_table(std::ostream& out, const nlohmann::ordered_json& report);
/// The same as a self-contained page with heat maps, campaign.html in the folder. Errors: InputError.
void write_page(const std::string& folder, const nlohmann::ordered_json& report);

}  // namespace m100::lab::campaign
