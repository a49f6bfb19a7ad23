// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace m100::lab::identify::paper {

// The identification method of the paper (III-D), as in its authors' published scripts, on the rows of their MAT-files.

/// A stick and its response, row by row, on the clock of the response.
struct Record {
  std::vector<double> t_s;
  std::vector<double> stick;     ///< counts from neutral
  std::vector<double> response;  ///< rad, rad/s or m/s
};

/// Samples by which the response follows the stick: the lag of the largest raw cross-correlation (means are not
/// removed, as in the authors' scripts), searched over |lag| <= 3 s.
int correlation_lag(const std::vector<double>& stick, const std::vector<double>& response, double period_s);

/// Eq. (1): delays the stick by `lag` samples, cuts both signals to [from_s, to_s], removes a straight line from each,
/// and fits the factor by least squares.
double scale_factor(const Record& record, int lag, double from_s, double to_s);

/// A transfer function without zeros, fitted to one long simulation: means removed from both signals, input held
/// between samples, initial state free.
struct Dynamics {
  double gain = 0.0;             ///< per unit of the scaled stick
  double time_constant_s = 0.0;  ///< first order
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double fit_percent = 0.0;
};
Dynamics first_order(const Record& record, double scale, double from_s, double to_s);
Dynamics second_order(const Record& record, double scale, double from_s, double to_s);

}  // namespace m100::lab::identify::paper
