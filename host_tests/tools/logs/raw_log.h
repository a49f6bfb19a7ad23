// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace m100::tools::logs {

/// One column as the file has it, before any scaling.
struct RawColumn {
  std::vector<double> values;
  std::vector<double> time_s;    ///< the stream's own clock, where the format gives each stream one (ULog); else empty
  std::vector<double> sequence;  ///< message counter found beside the column (MAT structs); else empty
};

/// A log file of some format, read column by column: only columns that somebody asks for have to be sound.
class RawLog {
 public:
  virtual ~RawLog() = default;
  RawLog(const RawLog&) = delete;
  RawLog& operator=(const RawLog&) = delete;

  /// @param asked_by the key of the column map that wants this column (for messages).
  /// @throws InputError: no such column, or a value that is not a finite number (file, line, column).
  virtual RawColumn column(const std::string& name, const std::string& asked_by) const = 0;

  /// Names that column() would accept, for `convert` and for messages.
  virtual std::vector<std::string> names() const = 0;

  /// Line of a sample (0-based) in the file, or its number where the format has no lines; for messages.
  virtual long line_of(std::size_t sample) const { return static_cast<long>(sample) + 1; }

  const std::string& file() const { return file_; }

 protected:
  explicit RawLog(std::string file) : file_(std::move(file)) {}

 private:
  std::string file_;
};

/// Comma (or semicolon, or tab) separated text; first line names; quotes, CRLF and a byte-order mark are fine.
std::unique_ptr<RawLog> open_csv(const std::string& file);
/// MATLAB 5 MAT-file. Columns are paths: `Experiment1.RCData.channel[1]` is row 1 (as MATLAB counts) of a matrix whose
/// longer side is time. Struct arrays and cells are not followed.
std::unique_ptr<RawLog> open_mat(const std::string& file);
/// ULog. Columns are `topic.field`, `topic.field[0]`, and `topic#1.field` for the second instance; each topic has its
/// own clock (`topic.timestamp`, in seconds).
std::unique_ptr<RawLog> open_ulog(const std::string& file);

/// ROS 1 bag 2.0, chunks plain or (built with libbz2) bz2. Columns are `/topic.field.path`, `/topic.axes[0]`, and
/// `/topic.time`: the header's stamp, else the time of reception, in seconds from the bag's first message.
std::unique_ptr<RawLog> open_rosbag(const std::string& file);

/// Chooses by the file's first bytes. @throws InputError: cannot be opened, empty, damaged.
std::unique_ptr<RawLog> open_log(const std::string& file);

/// "a, b, c" with at most `count` names, the nearest to `wanted` first: what a message offers when a name is unknown.
std::string nearest_names(const std::vector<std::string>& names, const std::string& wanted, std::size_t count = 6);

}  // namespace m100::tools::logs
