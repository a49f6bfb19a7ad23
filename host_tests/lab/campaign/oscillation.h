// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/experiments/trace.h"

namespace m100::lab::campaign {

/// Oscillation of a flight's tilt, measured from the flown angles alone, whatever the state of the failsafe.
struct TiltOscillation {
  /// On roll or pitch, in at least one window of 5 s, the deviation from the moving mean over 2 s exceeds 3 degrees
  /// root mean square, and its autocorrelation has a peak above 0.5 between 0.3 and 3.3 Hz.
  bool periodic = false;
  double roll_deviation_deg = 0.0;  ///< root mean square about the flight's mean
  double pitch_deviation_deg = 0.0;
};

/// @param trace one point every 10 ms. @param less a flight of the same course, whose tilt is subtracted
TiltOscillation measure_oscillation(const experiments::Trace& trace, const experiments::Trace& less = {});

/// Whether a flight is periodic and a flight of the same task in the nominal world (outcome.h), `reference`, is not.
/// @param hovers the task demands no tilt: then a deviation of more than 2 degrees about the mean and more than twice
///   the reference's, on roll or pitch, is an oscillation too.
bool oscillates(const TiltOscillation& flown, const TiltOscillation& reference, bool hovers);
/// Whether the flight is steady whatever the reference does, so that the reference need not be flown.
bool is_surely_steady(const TiltOscillation& flown, bool hovers);

}  // namespace m100::lab::campaign
