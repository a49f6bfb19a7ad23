// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

// Defects that a log itself shows. Nothing here knows a model.

/// Sets `valid` to 0 on the ground and for the first second after it, in every gap, and for `memory_s` after each gap,
/// because the past input is not known there. @param gap  of the signals that are used, as FlightLog::gap_of gives it
void mask_unusable(const logs::FlightLog& log, const std::vector<std::uint8_t>& gap,
                   const std::vector<std::pair<double, double>>& ground, double memory_s, std::vector<char>& valid);

/// How long [s] a moving signal holds one value: the median length of its runs of equal samples. One sample period or
/// less means that it is not held.
double hold_s(const std::vector<double>& values, const std::vector<char>& used, double period_s);

struct SampleGrid {
  double start_s = 0.0;
  double period_s = 0.01;
  double row_s = 0.0;  ///< time between the rows in which the signal was logged, if longer than a period
};

/// Share of the used samples at which a stick has its largest or smallest value: the log clipped it, or the pilot flew
/// to the stops. 0 if these values are not symmetric about zero, or if the stick mostly jumps there at once, as pulses
/// of a machine do and a hand does not (not tested in rows of 55 ms and more, which cannot show it).
double clipped_share(const std::vector<double>& stick, const std::vector<char>& used, const SampleGrid& clock);

/// Detects angles in degrees that are read as radians (roll or pitch beyond half a turn), and converts them to radians.
/// @param used  samples to check: samples outside of the ranges do not matter
/// @returns one finding, or nothing.
std::vector<Finding> repair_units(std::vector<double>& angle_rad, const std::vector<char>& used,
                                  const std::string& signal);

/// 1 for each sample inside of a range or within `margin_s` of one, 0 otherwise. Empty ranges: all samples.
std::vector<char> mask_ranges(const logs::FlightLog& log, const std::vector<std::pair<double, double>>& ranges,
                              double margin_s);

/// Repairs samples of a response that are not measurements. Frozen: more than five equal rows and four times the 90 %
/// quantile of its runs of equal values, with a jump at the end; or (unless coarsely quantised) an abrupt beginning and
/// ten times the 99 % quantile; removed from `used`. Outliers: more than 12 sigma (from second differences) and 5 % of
/// the large values off the median of five rows and all predictions by neighbours; the median replaces them.
/// @returns at most one finding for each kind, over the times of all its samples.
std::vector<Finding> repair_samples(std::vector<double>& values, std::vector<char>& used, const SampleGrid& clock,
                                    const std::string& signal);

/// Repairs samples of a stick that jump away and back within a tenth of a second, faster than a hand can: by more than
/// 12 sigma (sigma from second differences, at least that of its rounding) and 5 % of its large values, while their
/// neighbours agree. The median replaces them. Rows more than 50 ms apart cannot show this.
/// @returns at most one finding.
std::vector<Finding> repair_stick(std::vector<double>& values, const std::vector<char>& used, const SampleGrid& clock,
                                  const std::string& signal);

/// How much of a response one stick explains by a gain and a lag up to 0.6 s: the square of the best correlation.
double share_explained(const std::vector<double>& stick, const std::vector<double>& response,
                       const std::vector<char>& used, double period_s);

}  // namespace m100::lab::identify
