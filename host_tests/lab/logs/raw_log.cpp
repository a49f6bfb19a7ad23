// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/raw_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string_view>
#include <utility>

#include "firmware/companion/files/text/suggestion.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/alignment/bunched_arrivals.h"
#include "host_tests/lab/logs/formats/ardupilot.h"
#include "host_tests/lab/logs/formats/csv.h"
#include "host_tests/lab/logs/formats/mat.h"
#include "host_tests/lab/logs/formats/rosbag.h"
#include "host_tests/lab/logs/formats/rosbag2.h"
#include "host_tests/lab/logs/formats/ulog.h"
#include "host_tests/lab/logs/no_such_column.h"
#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kTextBytes = 4096;  // checked before a file is taken as text

/// Whether a file with this beginning may be text: it has no control characters other than white space.
bool may_be_text(std::string_view head) {
  return std::none_of(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == 0x7F || (byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f');
  });
}

bool is_mat(std::string_view head) {
  constexpr std::size_t kVersionAt = 124;
  const std::string_view version = head.size() >= 128 ? head.substr(kVersionAt, 4) : std::string_view();
  using namespace std::string_view_literals;
  return head.starts_with("MATLAB") || version == "\x00\x01IM"sv || version == "\x01\x00MI"sv;
}

/// A file format, recognised by magic bytes at an offset, and advice on how to convert the file.
struct ForeignFormat {
  std::size_t at;
  std::string_view magic;
  std::string_view advice;
};

/// Advice for a file of a known format that is not supported; empty: the format is unknown.
std::string_view remedy(std::string_view head) {
  using namespace std::string_view_literals;
  constexpr std::string_view kBlackboxCsv =
      "is a blackbox export of Betaflight with a preamble: delete the lines before 'loopIteration, ...', or make a CSV "
      "of "
      "the .bbl with blackbox_decode";
  constexpr std::string_view kDat = "is a DJI flight log (.DAT): make a CSV of it with DatCon";
  constexpr std::array<ForeignFormat, 18> kFormats{
      {{0, "\x89HDF"sv, "is HDF5 (a MAT-file of version 7.3?): save it with -v7"sv},
       {0, "\x89MCAP"sv, "is an MCAP recording: convert it to sqlite3 (ros2 bag convert), or to CSV"sv},
       {0, "\x1f\x8b"sv, "is compressed with gzip: unpack it first"sv},
       {0, "BZh"sv, "is compressed with bzip2: unpack it first"sv},
       {0,
        "\xfd"
        "7zXZ"sv,
        "is compressed with xz: unpack it first"sv},
       {0, "PK\x03\x04"sv, "is a zip archive: unpack it first"sv},
       {0, "\xff\xfe"sv, "is text with 16 bits per character: save it as UTF-8"sv},
       {0, "\xfe\xff"sv, "is text with 16 bits per character: save it as UTF-8"sv},
       {0, "FMT, 128"sv,
        "is ArduPilot's text log: read the binary log (.bin) of the flight, or make CSVs of it with mavlogdump.py"sv},
       {0, "FMT,128"sv,
        "is ArduPilot's text log: read the binary log (.bin) of the flight, or make CSVs of it with mavlogdump.py"sv},
       {0, "\"Product\",\"Blackbox"sv, kBlackboxCsv},
       {0, "Product,Blackbox"sv, kBlackboxCsv},
       {0, "H Product:Blackbox"sv, "is a blackbox log of Betaflight: make a CSV of it with blackbox_decode"sv},
       {0, "PAR1"sv, "is a Parquet table: save it as CSV, for example with pandas"sv},
       {16, "BUILD"sv, kDat},
       {242, "DJI_LOG_V3"sv, kDat},
       {0, "\xfe"sv, "is a raw MAVLink stream: make CSVs of it with mavlogdump.py"sv},
       {0, "\xfd"sv, "is a raw MAVLink stream: make CSVs of it with mavlogdump.py"sv}}};
  for (const ForeignFormat& format : kFormats) {
    if (head.substr(std::min(format.at, head.size()), format.magic.size()) == format.magic) {
      return format.advice;
    }
  }
  // Before each packet a telemetry log holds microseconds since 1970, most significant byte first: 00 03 from 1996
  // on, 00 07 until 2041. MAVLink packets begin with FE or FD.
  if (head.size() > 8 && head[0] == 0 && head[1] >= 3 && head[1] <= 7 && (head[8] == '\xfe' || head[8] == '\xfd')) {
    return "is a MAVLink telemetry log (.tlog): make CSVs of it with mavlogdump.py";
  }
  return {};
}

}  // namespace

void RawLog::require_mostly_sound(const std::vector<double>& values, const std::string& name) const {
  std::size_t bad = 0;
  std::size_t first = values.size();
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) {
      first = std::min(first, k);
      ++bad;
    }
  }
  if (bad > 0 && 2 * bad >= values.size()) {
    throw InputError(file_, line_of(first), name,
                     "sample " + std::to_string(first + 1) + " is not a finite number, and " + std::to_string(bad) +
                         " of " + std::to_string(values.size()) + " samples are not");
  }
}

void RawLog::no_such_column(const std::string& name, const std::string& map_key) const {
  throw NoSuchColumn(file_, 0, name,
                     "no such column (wanted for " + map_key + "); there are: " + nearest_names(names(), name));
}

TopicSummary summary_of(std::string name, std::string type, const std::vector<double>& time_s,
                        std::vector<std::string> fields, const std::vector<double>& counter) {
  TopicSummary out{
      .name = std::move(name), .type = std::move(type), .messages = time_s.size(), .fields = std::move(fields)};
  const std::optional<SpreadArrivals> spread =
      are_bunched(time_s) ? spread_arrivals(time_s, counter) : std::optional<SpreadArrivals>{};
  const std::vector<double>& sampled = spread ? spread->time_s : time_s;
  out.stretches = stretches_of(sampled);
  if (out.stretches.empty()) {
    return out;
  }
  out.from_s = out.stretches.front().from_s;
  out.to_s = out.stretches.back().to_s;
  std::vector<double> intervals;
  std::size_t at = 0;
  double last_s = out.from_s;
  for (std::size_t k = out.stretches.front().begin + 1; k < sampled.size(); ++k) {
    const bool begins = at + 1 < out.stretches.size() && out.stretches[at + 1].begin == k;
    at += begins ? 1U : 0U;
    if (sampled[k] > last_s && sampled[k] <= out.stretches[at].to_s) {
      intervals.push_back(sampled[k] - last_s);
    }
    last_s = begins ? sampled[k] : std::max(last_s, std::min(sampled[k], out.stretches[at].to_s));
  }
  if (intervals.empty()) {
    return out;
  }
  const double longest = std::max(0.05, 3.5 * median(intervals));
  std::sort(intervals.begin(), intervals.end());
  const auto gaps = std::upper_bound(intervals.begin(), intervals.end(), longest);
  out.gaps = static_cast<std::size_t>(intervals.end() - gaps);
  out.longest_gap_s = out.gaps > 0 ? intervals.back() : 0.0;
  const double sampled_s = std::accumulate(intervals.begin(), gaps, 0.0);
  out.rate_hz =
      sampled_s > 0.0 ? static_cast<double>(intervals.size() - out.gaps) / sampled_s : 1.0 / median(intervals);
  return out;
}

std::string nearest_names(const std::vector<std::string>& names, const std::string& wanted, std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> ranked(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    ranked[i] = {companion::edit_distance(names[i], wanted), i};
  }
  const std::size_t shown = std::min(count, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(shown), ranked.end());
  std::string text;
  for (std::size_t i = 0; i < shown; ++i) {
    text += (i == 0 ? "" : ", ") + printable(names[ranked[i].second], 100);
  }
  return text + (names.size() > count ? ", ..." : "");
}

std::unique_ptr<RawLog> open_log(const std::string& file) {
  require_regular(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw InputError(file, 0, "", "cannot be opened");
  }
  std::string head(kTextBytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  using namespace std::string_view_literals;
  if (head.empty()) {
    throw InputError(file, 0, "", "is empty");
  }
  if (head.starts_with("ULog\x01\x12\x35"sv)) {
    return open_ulog(file);
  }
  if (head.starts_with("\xa3\x95\x80"sv)) {
    return open_ardupilot(file);
  }
  if (head.starts_with("SQLite format 3\0"sv)) {
    return open_rosbag2(file);
  }
  if (head.starts_with("#ROSBAG")) {
    if (!head.starts_with("#ROSBAG V2.0\n")) {
      throw InputError(file, 0, "", "not a ROS bag of format 2.0");
    }
    return open_rosbag(file);
  }
  if (is_mat(head)) {
    return open_mat(file);
  }
  if (const std::string_view what = remedy(head); !what.empty()) {
    throw InputError(file, 0, "", std::string(what));
  }
  if (!may_be_text(head)) {
    throw InputError(file, 0, "", "has an unknown format (known: CSV, MAT 5 and 7.3, ULog, ArduPilot .bin, ROS bags)");
  }
  return open_csv(file);
}

}  // namespace m100::lab::logs
