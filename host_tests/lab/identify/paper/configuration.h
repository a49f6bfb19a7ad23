// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"

namespace m100::lab::identify::paper {

/// One row of the page of the configuration: what the paper prints, what its authors published later for this aircraft
/// (model/paper.h names the file), and what `--law paper` flies.
struct ConfigurationRow {
  std::string what, printed, published, flown;
};

/// The rows for `flown`, a model::paper_configuration().
std::vector<ConfigurationRow> configuration_rows(const model::Vehicle& flown);

}  // namespace m100::lab::identify::paper
