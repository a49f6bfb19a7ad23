// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/companion/files/recorded_flight.h"
#include "firmware/core/fence.h"
#include "protocol/cipher.h"

namespace m100::lab::flight {

using Axes = std::array<std::vector<double>, 3>;  ///< x, y, z or roll, pitch, yaw

/// Values over time; both vectors have the same length.
struct Timed {
  std::vector<double> t_s;
  std::vector<double> values;
};

/// A step of the failsafe; the reason is empty if the log could not be replayed with the same number of steps.
struct FailsafeChange {
  double t_s = 0.0;
  std::string from, to, reason;
};

/// A pose that arrived.
struct Pose {
  double t_s = 0.0;  ///< of the arrival
  double captured_s = 0.0;
  std::array<double, 3> position_m{};
};

/// Root mean square error of the prediction from the sticks by the log's vehicle file, at each of
/// identify::kHorizons_s.
struct PredictionRow {
  std::string quantity;
  std::vector<double> errors;
};

/// What a page shows of one flight, or of a recording of a flight by hand. Times are seconds since the log's begin;
/// world NWU, SI. Vectors without data are empty.
struct FlightSeries {
  std::string name;           ///< the log's file name
  bool is_recording = false;  ///< by `m100 record`: no course, no commands, no failsafe
  std::vector<double> t_s;    ///< of the ticks: the time of every vector of ticks below
  Axes position_m;            ///< ticks, as estimated
  Axes reference_m;           ///< ticks: where the course is at that time
  Axes attitude_rad;          ///< ticks of attitude_t_s, as measured: roll, pitch, yaw
  std::vector<double> attitude_t_s;
  std::array<std::vector<double>, 4> granted;                 ///< ticks, after the supervisor
  std::array<Timed, 4> sticks_counts;                         ///< sent: roll, pitch, throttle, yaw; recorded: of 10000
  std::array<std::vector<double>, 2> disturbance_m_s2;        ///< ticks, x and y: as the observer estimated in flight
  std::array<std::vector<double>, 2> found_disturbance_m_s2;  ///< ticks, as the poses show it afterwards
  std::vector<double> residual;         ///< ticks: of the worst axis against its model, as a multiple of the expected
  std::vector<double> telemetry_age_s;  ///< ticks
  std::vector<double> vibration_m_s2, vibration_peak_m_s2;  ///< ticks, as est::VibrationStatus; empty: not replayed
  std::vector<double> late_s;                               ///< ticks: how late they were
  std::vector<std::uint8_t> state;                          ///< ticks: safety::FailsafeState
  std::vector<Pose> poses;
  Timed battery_percent;
  std::vector<FailsafeChange> changes;
  double control_s = 0.0;    ///< when the law first flew; if it never did: the log's begin
  double end_s = 0.0;        ///< when the law flew last; 0: it never flew; of a recording: its end
  double lost_share = -1.0;  ///< of the pose sender's frames, by their sequence numbers; negative: unknown
  std::uint32_t refused_poses = 0;
  std::optional<core::Fence> fence;
  double tilt_limit_rad = 0.0;
  std::vector<PredictionRow> predictions;  ///< filled by add_predictions()
  std::vector<std::string> notes;          ///< sentences about what the page cannot show, and why

  bool flew() const { return end_s > control_s && !is_recording; }
};

/// Reads a log of `m100 fly` or a recording of `m100 record`.
/// @param cipher of the app's key, for a flight with encrypted commands; otherwise null.
/// @throws InputError: the file is neither, or is damaged.
FlightSeries read_series(const std::string& file, const protocol::Cipher* cipher);

/// The series of a log of `m100 fly` that has been read. Its reasons, battery and losses come from a replay.
FlightSeries series_of(const companion::RecordedFlight& flight, const std::string& name,
                       const protocol::Cipher* cipher);

}  // namespace m100::lab::flight
