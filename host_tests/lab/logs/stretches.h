// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace m100::lab::logs {

/// The seconds that are put between stretches, and between joined logs: longer than any model's memory of its input
/// (3 s) and than any filter.
inline constexpr double kPause_s = 5.0;

/// A longer hole is a pause of the recorder: motion capture has lost an aircraft for 6.5 s in flight, and a landing, a
/// change of the battery or another take-off needs more than 10 s.
inline constexpr double kLongestDropout_s = 10.0;

/// A part of a log in which the clock runs on. A pause, a second flight in the file and a clock that was set begin a
/// new one.
struct Stretch {
  std::size_t begin = 0;    ///< its first sample
  std::size_t samples = 0;  ///< without those whose time stamp cannot be used
  double from_s = 0.0;      ///< first and last time, as they stand in the file
  double to_s = 0.0;
  std::size_t set_back = 0;  ///< how often the clock was set back before
  double shift_s = 0.0;      ///< from the file's clock to the continuous one, on which kPause_s lie between stretches
};

/// The stretches of a stream by its time stamps; single ones that are wrong begin none. Slow streams pause for more
/// than 3.5 of their own intervals. A clock that goes on falling is not set back, but runs backwards: it stays in one
/// stretch.
std::vector<Stretch> stretches_of(const std::vector<double>& time_s);

/// The stretches of at least `fewest` samples, or the first one of all. Each begins at a time of the grid of `period_s`
/// that begins with the first.
std::vector<Stretch> placed(const std::vector<Stretch>& own, std::size_t fewest, double period_s);

/// "0.00 to 12.50 s, 60.00 to 91.00 s"
std::string list_of(const std::vector<Stretch>& stretches);

/// The times on the continuous clock of `log`, which is not empty: the stretches of the log's clock. `own` are those of
/// these times. Infinite: not in a stretch of the log, nor within half of kPause_s of it.
std::vector<double> continuous(const std::vector<double>& time_s, const std::vector<Stretch>& own,
                               const std::vector<Stretch>& log);

}  // namespace m100::lab::logs
