// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/model/axis/stick_commands.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// One stick axis of one log, or of several joined logs, on a uniform clock. Sample i is at start_s + i period_s.
struct AxisData {
  static constexpr double kSlowestStick_s = 0.02;  ///< longest time between samples of a remote control

  double start_s = 0.0;
  double period_s = 0.01;
  double row_s = 0.0;         ///< between the logged rows of the response; 0: a period
  double stick_row_s = 0.0;   ///< between the logged rows of the stick, which may be shorter than a period; 0: a period
  std::vector<double> stick;  ///< counts from neutral, or commands in the axis' unit
  std::vector<double> other;  ///< stick of the other axis; empty: not logged
  std::vector<double> measured;      ///< unit of the axis
  std::vector<char> valid;           ///< 0: gap, ground or frozen; same length as measured
  std::vector<std::size_t> flights;  ///< first samples of the logs that were joined; empty: one log
  /// Seconds from the start of the sample's log (of joined logs, its own) to the sample.
  double since_begin_s(std::size_t sample) const {
    std::size_t begin = 0;
    for (const std::size_t flight : flights) {
      begin = flight <= sample ? flight : begin;
    }
    return period_s * static_cast<double>(sample - begin);
  }
  double logged_stick_row_s() const { return stick_row_s > 0.0 ? stick_row_s : period_s; }
  /// Longest time [s] between a step of the stick and the middle of the sample that shows it. Fast rows are averaged
  /// over a period, so it is half a row. Slower rows are interpolated: it is half the sum of row and period.
  /// @param step_s  longest time in which the step goes unseen [s]: at most the time between two logged rows
  double max_reading_lag_s(double step_s) const { return 0.5 * (1.5 * step_s < period_s ? step_s : step_s + period_s); }
  double time_s(std::size_t sample) const { return start_s + period_s * static_cast<double>(sample); }
};

/// Part of a log, divided into consecutive blocks. The simulation of each block starts from the measured value and
/// slope. A block ends before a gap. Pieces that are shorter than half a block and shorter than 1.25 s are left out.
class AxisBlocks {
 public:
  struct Block {
    std::size_t begin;  ///< first sample
    std::size_t end;
    double value;
    double rate_per_s;
    std::size_t stretch;  ///< index of the range that contains it
  };
  /// Time before each range in which the stick is used, too, for the delay and for effects with memory of the stick.
  static constexpr double kPast_s = 3.0;
  static constexpr double kBlock_s = 2.5;
  static constexpr std::size_t kLanes = 4;          ///< blocks that are simulated side by side
  static constexpr std::size_t kStartSamples = 11;  ///< whose quadratic is the initial state of a block

  AxisBlocks(const AxisData& data, const std::vector<Range>& ranges, double block_s = kBlock_s);

  const AxisData& data() const { return *data_; }
  std::size_t size() const { return blocks_.size(); }
  const Block& operator[](std::size_t block) const { return blocks_[block]; }
  std::size_t samples() const { return samples_; }

  /// Simulated minus measured of the blocks with positive weight, one after the other, times the root of the weight;
  /// zero at invalid samples. An empty span of weights means all ones.
  /// @returns the number of values written.
  std::size_t error(const model::StickAxis& axis, std::span<const int> weights, std::span<double> out) const;
  /// The simulated response of all blocks, one after the other, in the unit of the axis.
  std::vector<double> response(const model::StickAxis& axis) const;
  /// Root mean square of error() over all blocks.
  double rmse(const model::StickAxis& axis) const;
  /// 100 (1 - |error| / |measured - mean|); 0 where the measured response is constant.
  double fit_percent(const model::StickAxis& axis) const;
  /// Frees what is kept between simulations to make them faster; an hour of log keeps 6 to 12 MB.
  void release_buffers() const;

 private:
  /// The simulated response of at most kLanes blocks, block after block. @returns the number of values written.
  std::size_t run(const model::StickAxis& axis, std::span<const Block* const> blocks, std::span<double> out) const;
  std::size_t simulate(const model::StickAxis& axis, std::span<const int> weights, std::span<double> out) const;

  const AxisData* data_;
  StickCommands commands_{true};
  std::vector<Block> blocks_;
  std::size_t samples_ = 0;
  mutable std::vector<double> driven_;
};

/// The prediction error over starts every 0.1 s inside the ranges.
HorizonErrors horizon_rmse(const AxisData& data, const std::vector<Range>& ranges, const model::StickAxis& axis);

}  // namespace m100::lab::identify
