// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "firmware/companion/files/text/json.h"

namespace m100::lab::campaign {

/// Prints a report (to_json, merged) as a table, and each failure with the command that repeats it.
void print_table(std::ostream& out, const Json& report);
/// Writes the report as a self-contained page with heat maps, campaign.html in the folder. Errors: InputError.
/// @param flights pages of single flights in the folder: what each shows, and its file name
void write_page(const std::string& folder, const Json& report,
                const std::vector<std::pair<std::string, std::string>>& flights);

}  // namespace m100::lab::campaign
