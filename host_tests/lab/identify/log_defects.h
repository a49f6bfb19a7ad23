// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

// What is wrong with a log, as far as the log itself shows it. Nothing here knows a model.

/// 0 where `valid` is to be left out: on the ground and the first second after, and `memory_s` after every gap, in
/// which the past input is not known. @param gap of the signals that are used, as FlightLog::gap_of gives it.
void mask_unusable(const logs::FlightLog& log, const std::vector<std::uint8_t>& gap,
                   const std::vector<std::pair<double, double>>& ground, double memory_s, std::vector<char>& valid);

/// How long a moving signal holds one value: the median length of its runs of equal samples. One sample period or less:
/// not held.
double hold_s(const std::vector<double>& values, const std::vector<char>& used, double period_s);

struct Clock {
  double start_s = 0.0;
  double period_s = 0.01;
  double row_s = 0.0;  ///< between the rows in which the signal was logged, where that is more than a period
};

/// Share of the used samples on which a stick stands at one and the same largest value, on both sides alike: a log that
/// was cut there, or a pilot who flies stops only. 0 where it mostly comes there at once, as pulses of a machine do and
/// no hand; rows of 55 ms and more cannot tell.
double cut_share(const std::vector<double>& stick, const std::vector<char>& used, const Clock& clock);

/// Degrees, taken for radians: roll or pitch beyond half a turn, which no attitude is. Turns them into radians.
/// @param used  which samples are looked at: what was not asked about does not matter
/// @returns one finding, or nothing.
std::vector<Finding> repair_units(std::vector<double>& angle_rad, const std::vector<char>& used,
                                  const std::string& signal);

/// 0 where a sample is neither inside of a range nor within `margin_s` of one. Empty ranges: all samples.
std::vector<char> inside(const logs::FlightLog& log, const std::vector<std::pair<double, double>>& ranges,
                         double margin_s);

/// Samples of a response that are not measurements. Frozen: five equal rows or more, against the signal's own cadence
/// (a tenth of the signal's runs may be as long as a quarter of it), and a jump where it moves on; they are taken out
/// of `used`. Outliers: more than 12 sigma from the median of five, sigma from second differences, and more than 5 % of
/// the amplitude; the median takes their place.
/// @returns at most one finding for each kind, over the times of all its samples.
std::vector<Finding> repair_samples(std::vector<double>& values, std::vector<char>& used, const Clock& clock,
                                    const std::string& signal);

/// Samples of a stick that jump away and back within a tenth of a second, as no hand does: by more than 12 sigma (sigma
/// from second differences, at least that of its rounding) and 5 % of its large values, with neighbours that agree. The
/// median takes their place. Rows more than 50 ms apart cannot tell. @returns at most one finding.
std::vector<Finding> repair_stick(std::vector<double>& values, const std::vector<char>& used, const Clock& clock,
                                  const std::string& signal);

/// How much of a response one stick explains by a gain and a lag up to 0.6 s: the square of the best correlation.
double share_explained(const std::vector<double>& stick, const std::vector<double>& response,
                       const std::vector<char>& used, double period_s);

}  // namespace m100::lab::identify
