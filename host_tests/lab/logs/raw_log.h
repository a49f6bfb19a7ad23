// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host_tests/lab/logs/stretches.h"

namespace m100::lab::logs {

/// One column of the file before any scaling. A value that is not a finite number (a spoilt row, an empty cell, a
/// message that is too short) is NaN, which becomes a gap.
struct RawColumn {
  std::vector<double> values;
  std::vector<double> time_s;    ///< the stream's own clock, if the format has one per stream; otherwise empty
  std::vector<double> sequence;  ///< message counter of the column's struct (MAT) or topic (ROS); otherwise empty
};

/// Summary of one stream of a log.
struct TopicSummary {
  std::string name;  ///< as in column names; empty: the file has only one stream
  std::string type;  ///< name of the type in the file; may be empty
  std::size_t messages = 0;
  double from_s = 0.0, to_s = 0.0;   ///< first and last time, on the clock of the columns
  std::vector<Stretch> stretches{};  ///< none: no clock is known
  double rate_hz = 0.0;              ///< samples over time, without the gaps; 0: no clock is known
  std::size_t gaps =
      0;  ///< intervals longer than 50 ms and 3.5 median intervals, after spreading bunches; pauses count
  double longest_gap_s = 0.0;
  std::vector<std::string> fields;  ///< an array is one entry in ULog ("q[4]") and MAT
};

/// Computes the rate and gaps of a stream; time stamps that are not finite or do not increase within a stretch are
/// ignored. Bunched
/// arrivals are spread first. @param counter  message counter; empty: there is none.
TopicSummary summary_of(std::string name, std::string type, const std::vector<double>& time_s,
                        std::vector<std::string> fields, const std::vector<double>& counter = {});

/// A log file of some format, read column by column: only the columns that are read need to be sound. Whatever the file
/// holds, memory and time are at most a constant times its size.
class RawLog {
 public:
  virtual ~RawLog() = default;
  RawLog(const RawLog&) = delete;
  RawLog& operator=(const RawLog&) = delete;

  /// @param map_key the key of the column map that wants this column (for messages).
  /// @throws InputError: no such column, no number, or half of its values or more spoilt (empty CSV cells are not).
  virtual RawColumn column(const std::string& name, const std::string& map_key) const = 0;

  /// Names that column() accepts, at most kMaxNames of them.
  virtual std::vector<std::string> names() const = 0;
  static constexpr std::size_t kMaxNames = 100'000;

  virtual std::vector<TopicSummary> topics() const { return {}; }

  /// "CSV", "ULog", ...
  virtual std::string format() const { return ""; }

  /// Whether times of this format are those at which the logger received the samples, not those of the sensors.
  virtual bool has_times_of_arrival() const { return true; }

  /// Sentences for the report about data that were damaged or left out when the file was opened.
  virtual std::vector<std::string> notes() const { return {}; }

  /// Line of a sample (0-based) in the file, or its number where the format has no lines; for messages.
  virtual long line_of(std::size_t sample) const { return static_cast<long>(sample) + 1; }

  const std::string& file() const { return file_; }

 protected:
  explicit RawLog(std::string file) : file_(std::move(file)) {}

  /// @throws InputError if at least half of the values are not finite numbers, naming the first of these.
  void require_mostly_sound(const std::vector<double>& values, const std::string& name) const;
  /// @throws NoSuchColumn with the most similar names.
  [[noreturn]] void no_such_column(const std::string& name, const std::string& map_key) const;

 private:
  std::string file_;
};

/// Opens a log; the file's first bytes decide its format. @throws InputError: cannot be opened, not a regular file,
///   empty, unknown format, damaged.
std::unique_ptr<RawLog> open_log(const std::string& file);

/// "a, b, c" with at most `count` names, the most similar to `wanted` first: suggestions for a message about an unknown
/// name. Cost: linear in the number of names.
std::string nearest_names(const std::vector<std::string>& names, const std::string& wanted, std::size_t count = 6);

}  // namespace m100::lab::logs
