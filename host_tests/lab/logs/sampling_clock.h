// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::lab::logs {

/// Times at which the samples of a log's streams were taken, if the log has only the times of their arrival.
///
/// A stream whose arrivals are bunched is spread by its counter or else by its regular rate, and a note says so. Any
/// other stream keeps its times.
class SamplingClock {
 public:
  /// @param stream  name of the stream, for the note. @param counter  empty if there is none.
  /// @param values  samples of one column. If times repeat without a counter and the values mostly repeat with them,
  ///   the repetitions are rows and not samples, and the times are kept.
  /// Cost: linear in the samples, once for each clock.
  std::vector<double> times(const std::string& stream, const std::vector<double>& arrival_s,
                            const std::vector<double>& counter, const std::vector<double>& values);
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Known {
    std::vector<double> arrival_s;
    std::vector<double> time_s;
  };
  std::vector<Known> known_;
  std::vector<std::string> notes_;
};

}  // namespace m100::lab::logs
