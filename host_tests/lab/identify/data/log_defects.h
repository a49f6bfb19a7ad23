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
/// to the stops. 0 if these two values are not symmetric about zero, or if the stick mostly jumps to them within one
/// row, as the pulses of a machine do and a hand does not (not tested if rows are 55 ms apart or more).
double clipped_share(const std::vector<double>& stick, const std::vector<char>& used, const SampleGrid& clock);

/// Detects angles in degrees that are read as radians (roll or pitch beyond half a turn), and converts them to radians.
/// @param used  samples that are checked; all samples are converted
/// @returns one finding, or nothing.
std::vector<Finding> repair_units(std::vector<double>& angle_rad, const std::vector<char>& used,
                                  const std::string& signal);

/// 1 for each sample inside of a range or within `margin_s` of one, 0 otherwise. Empty ranges: all samples.
std::vector<char> mask_ranges(const logs::FlightLog& log, const std::vector<std::pair<double, double>>& ranges,
                              double margin_s);

/// Repairs samples of a response that are not measurements. Frozen samples are removed from `used`: runs of equal
/// values that are much longer than usual for this signal and end with a jump or begin abruptly. Outliers are replaced
/// by the median of five rows: values far from that median and from all predictions by their neighbours.
/// @returns at most one finding for frozen samples and one for outliers.
std::vector<Finding> repair_samples(std::vector<double>& values, std::vector<char>& used, const SampleGrid& clock,
                                    const std::string& signal);

/// Replaces samples of a stick that jump away and back within 0.1 s, faster than a hand can, by the median of five
/// rows. A stick whose rows are more than 50 ms apart is not changed. @returns at most one finding.
std::vector<Finding> repair_stick(std::vector<double>& values, const std::vector<char>& used, const SampleGrid& clock,
                                  const std::string& signal);

/// Share of a response that one stick explains by a gain and a lag up to 0.6 s: the square of the best correlation.
double share_explained(const std::vector<double>& stick, const std::vector<double>& response,
                       const std::vector<char>& used, double period_s);

}  // namespace m100::lab::identify
