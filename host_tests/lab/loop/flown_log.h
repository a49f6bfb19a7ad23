// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::loop {

/// Column map of our own flight logs: what `m100-lab identify --columns` needs for them.
const std::string& own_columns();

/// The course of an identification flight: unforeseen jumps in x, y, height and heading of many sizes, so that every
/// stick is swept through its dead zone and its range, first slowly, then fast; inside a fence of +-3 m about the start
/// and +-0.8 m in height. Same seed, same course.
std::string excitation(std::uint64_t seed, double duration_s);

/// Writes the flight's ULog to a file and reads it back as a log of any origin. Errors: InputError.
logs::FlightLog load_flown(const experiments::FlightResult& flight, const std::string& path);

}  // namespace m100::lab::loop
