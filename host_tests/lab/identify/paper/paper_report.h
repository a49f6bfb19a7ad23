// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::identify::paper {

/// A number as printed in the paper (NaN: it is not), as reproduced from the authors' own rows with their method, and
/// as found after aligning the streams by their message counters (both NaN: no data was published).
struct ReproducedNumber {
  std::string quantity;
  double paper;
  double reproduced;
  double aligned;
  std::string why = {};  ///< why the reproduced number is another than the printed one
};
/// "reproduced": to the digits that the paper prints; "different: " and why; "no data published"; empty: not printed.
std::string verdict(const ReproducedNumber& number);

struct Report {
  std::vector<ReproducedNumber> lines;
  int stick_shift_samples = 0;  ///< rows by which the sticks were early in the authors' tables
  std::string evidence;         ///< of the shift
};

/// Reproduces Tables I and II, without the yaw rate, from ExperimentPitchRoll.mat and ExperimentHeight.mat.
/// @throws InputError: files of another kind.
Report reproduce(const std::string& pitch_roll_file, const std::string& height_file);

/// Adds the yaw rate from ExperimentYaw.mat. The equation of III-D.3 comes from the odometry's rate. Table II comes
/// from the rate of the IMU stream, which is 3 rows early in the authors' tables, so its time constant is 30 ms
/// shorter.
/// @throws InputError: a file of another kind.
void add_yaw(Report& report, const std::string& yaw_file);

}  // namespace m100::lab::identify::paper
