// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

namespace m100::lab::identify {

struct TimeSeries {
  std::vector<double> time_s;
  std::vector<double> values;
};

struct SpectralPeak {
  double frequency_hz = 0.0;
  double share = 0.0;  ///< of the variance of all series together
};

/// The strongest spectral peak of several series with the same clock, by least squares. The frequencies searched begin
/// at 2.5 periods in the time span and end at 5 Hz. Cost: samples times frequencies.
SpectralPeak strongest_peak(const std::vector<TimeSeries>& series);

/// Share of the variance about a straight line over time that a sinusoid of this frequency explains.
double share_at(const TimeSeries& series, double frequency_hz);

/// Input of check_vehicle_motion(). A periodic force may only be named if the vehicle itself does not move with that
/// period, because on a periodic path every measured signal has that spectral peak.
struct VehicleMotion {
  double frequency_hz;
  std::array<std::array<double, 2>, 2> force;  ///< cosine and sine amplitude on x and y [m/s^2]
  std::array<TimeSeries, 2> residual;          ///< before the force is taken out
  struct Channel {
    std::string name;
    int moved_by_axis;  ///< velocity: axis of the force that moves it, whose effect is subtracted first; -1: none
    std::vector<double> values;
  };
  std::vector<Channel> channels;
  std::vector<double> speed_m_s;  ///< empty: not logged
};

/// Decides whether the vehicle itself moves at the frequency of the force. @returns a sentence with the channel that
/// has the largest share of its power there, if that is more than 15 %. Empty if all shares are smaller, or if hovering
/// shows the force: an oscillation fitted while the vehicle moves predicts more than 30 % of the residual in hover.
std::string check_vehicle_motion(const VehicleMotion& motion);

}  // namespace m100::lab::identify
