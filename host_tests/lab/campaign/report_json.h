// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/campaign/campaign.h"

namespace m100::lab::campaign {

/// Joins the parts of a campaign into byte for byte the JSON that one process would have written. Errors: InputError if
/// a file is not a part of a campaign, the parts are of different campaigns, or flights occur twice or are missing.
Json merged(const std::vector<std::string>& paths);
/// Whether every flight of a report stayed.
bool all_stayed(const Json& report);
/// The report as JSON: "worlds" with the summaries, "campaign" with the settings, and "flown" with each flight, from
/// which the summaries are computed. "part" is present only if this is a part of a campaign.
Json to_json(const Campaign& campaign, const Share& share, const std::vector<Flown>& flown);

}  // namespace m100::lab::campaign
