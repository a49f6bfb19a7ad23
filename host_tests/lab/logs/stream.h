// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace m100::lab::logs {

/// Samples of one signal with their times. Once tidied: both finite, times strictly increasing.
struct Stream {
  std::vector<double> time_s;
  std::vector<double> values;
  std::vector<std::uint8_t> after_spoilt;  ///< 1: something between the sample before and this one could not be used
};

/// What was not taken into a tidy stream.
struct Untidy {
  std::size_t repeated = 0;  ///< stamps that were there already: the first sample of each is kept
  std::size_t spoilt = 0;    ///< samples or stamps that are no finite numbers, single stamps far out of order
};

/// The samples in order. A single stamp that jumps ahead or back, with order around it, is a spoilt sample.
/// @param backwards out: index of the sample at which time really runs backwards; the size of the stream where it does
///   not. What lies behind it is left out.
Stream tidied(const Stream& stream, Untidy& untidy, std::size_t& backwards);

/// The stream on a grid of `size` times, linear in between and held beyond its ends.
/// @param gap out: 1 is written where nothing was sampled: inside a hole longer than 50 ms or 3.5 of the stream's own
///   intervals, between the neighbours of a spoilt sample, more than one period beyond the ends.
std::vector<double> resampled(const Stream& tidy, double start_s, double period_s, std::size_t size,
                              std::vector<std::uint8_t>& gap);

/// y(at) by the straight line through its neighbours. Preconditions: at least two values; `at` does not decrease from
/// call to call with the same hint.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at, std::size_t& hint);

/// Precondition: not empty.
double median(std::vector<double> values);

}  // namespace m100::lab::logs
