// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace m100::lab::logs {

/// Samples of one signal with their times. In a tidied stream both are finite and times increase strictly.
struct Stream {
  std::vector<double> time_s;
  std::vector<double> values;
  std::vector<std::uint8_t>
      after_spoilt;  ///< 1: an unusable sample was dropped between the previous sample and this one
};

/// Counts of the samples that a tidied stream leaves out.
struct StreamDefects {
  std::size_t repeated = 0;  ///< repeated time stamps; the first sample of each is kept
  std::size_t spoilt = 0;    ///< samples or time stamps that are not finite, single time stamps out of order
};

/// The usable samples in order of time. A single time stamp that jumps ahead or back between ordered ones is spoilt.
/// @param backwards receives the index of the sample at which time really runs backwards, which is left out with all
///   later ones, or the size of the stream if time does not.
Stream without_defects(const Stream& stream, StreamDefects& untidy, std::size_t& backwards);

/// Resamples the stream onto a grid of `size` times: linear interpolation, held beyond the ends.
/// @param gap receives 1 where nothing was sampled: inside a hole longer than 50 ms and 3.5 of the stream's own
///   intervals, between the neighbours of a spoilt sample, more than one period beyond the ends.
std::vector<double> resampled(const Stream& tidy, double start_s, double period_s, std::size_t size,
                              std::vector<std::uint8_t>& gap);

/// Mean of the stream, interpolated linearly, over the period that follows each time of the grid. A command that is
/// held at this mean for the period moves a vehicle in the same way.
std::vector<double> period_means(const Stream& tidy, double start_s, double period_s, std::size_t size);

/// y(at) by linear interpolation, and beyond the ends by extrapolation. Preconditions: at least two values; `hint`
/// starts at 0, and `at` does not decrease from call to call with the same hint.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at, std::size_t& hint);

/// Removes the jumps by whole turns.
void unwrap_angle(std::vector<double>& angle_rad);

/// Precondition: not empty.
double median(std::vector<double> values);

/// Removes the wraps of a 16-bit counter.
std::vector<double> unwrapped(std::vector<double> counter);

}  // namespace m100::lab::logs
