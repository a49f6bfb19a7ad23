// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/setpoint/setpoint_law.h"

namespace m100::lab::gains {

/// The tables of a vehicle, and the rows of their set-point laws; attach() joins them.
struct TableSet {
  mpc::GainTables<double> tables;  ///< without the rows below
  SetpointRows x;
  SetpointRows y;
};

/// Both axes' tables of a vehicle file, with set-point law. Throws std::domain_error if the model is not controllable.
TableSet make_table_set(const companion::VehicleFile& file, const SetpointBox& box = kSetpointBox,
                        const SetpointProgress& progress = {});

/// The bytes of a gain table file (firmware/mpc/table_file.h).
std::vector<std::byte> to_file(const TableSet& set);

/// The text of firmware/mpc/generated/gain_table.h: the vehicle and both tables as constants.
std::string to_header(const TableSet& set, const model::Vehicle& vehicle);

}  // namespace m100::lab::gains
