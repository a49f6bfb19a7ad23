// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/text/plain_number.h"
#include "firmware/companion/files/text/suggestion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

namespace m100::companion {
namespace {

constexpr std::array<std::string_view, ctl::kStickAxes> kNames{"roll", "pitch", "throttle", "yaw"};
constexpr double kPeriod_s = 0.02;
constexpr double kTravel_counts = 660.0;
constexpr std::size_t kMaxPieces = 255;       // the log's record counts them in a byte
constexpr std::size_t kMaxNoteBytes = 59000;  // below log::kLongestNote_bytes
constexpr double kMaxTilt_rad = 0.6;          // promise R12 allows 35 degrees

[[noreturn]] void fail(const std::string& name, long line, const std::string& what) {
  throw FileError(name, line, "", what);
}

std::optional<std::size_t> axis_of(std::string_view word) {
  const auto found = std::find(kNames.begin(), kNames.end(), word);
  return found == kNames.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - kNames.begin()));
}

/// "roll distance 8 braking 2 speed 6 tilt 0.5"
void read_limits(std::istringstream& words, ExcitationFile& out, const std::string& name, long line) {
  std::string axis, distance, braking, speed, tilt;
  ctl::ExcitationLimits limits;
  words >> axis >> distance >> limits.distance >> braking >> limits.braking >> speed >> limits.speed >> tilt >>
      limits.tilt_rad;
  const std::optional<std::size_t> index = axis_of(axis);
  const auto positive = [](double value) { return value > 0.0 && value <= 1000.0; };
  if (!words || !index || distance != "distance" || braking != "braking" || speed != "speed" || tilt != "tilt" ||
      !positive(limits.distance) || !positive(limits.braking) || !positive(limits.speed) ||
      !(limits.tilt_rad > 0.0 && limits.tilt_rad <= kMaxTilt_rad)) {
    fail(name, line,
         "expected: limits roll|pitch|throttle|yaw distance M braking M_S2 speed M_S tilt RAD, tilt up to 0.6");
  }
  out.limits[*index] = limits;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    cell.erase(cell.find_last_not_of(" \t\r") + 1);
    cells.push_back(cell.substr(std::min(cell.size(), cell.find_first_not_of(" \t"))));
  }
  return cells;
}

double number(const std::vector<std::string>& cells, std::size_t column, const std::string& name, long line) {
  if (column >= cells.size() || !is_plain_number(cells[column])) {
    fail(name, line, "column " + std::to_string(column + 1) + " is not a number");
  }
  return std::stod(cells[column]);
}

/// Reads the rows of the table.
class ExcitationParser {
 public:
  ExcitationParser(ExcitationFile& out, std::string name) : out_(out), name_(std::move(name)) {}

  void head(const std::vector<std::string>& cells, long line) {
    for (std::size_t column = 0; column < cells.size(); ++column) {
      if (cells[column] == "t_s") {
        time_ = column;
      } else if (cells[column] == "piece") {
        piece_ = column;
      } else if (cells[column].rfind("stick_", 0) == 0) {
        const std::optional<std::size_t> axis = axis_of(cells[column].substr(6));
        if (!axis) {
          fail(name_, line, "'" + cells[column] + "': no such stick" + did_you_mean(cells[column].substr(6), kNames));
        }
        sticks_.emplace_back(*axis, column);
      }
    }
    if (!time_ || !piece_ || sticks_.empty()) {
      fail(name_, line, "needs the columns t_s, piece and stick_roll, stick_pitch, stick_throttle or stick_yaw");
    }
  }
  bool has_head() const { return time_.has_value(); }

  void row(const std::vector<std::string>& cells, long line) {
    const double at_s = number(cells, *time_, name_, line);
    if (rows_ > 0 && std::abs(at_s - last_s_ - kPeriod_s) > 1e-3) {
      fail(name_, line, "'t_s': samples must be 0.02 s apart");
    }
    last_s_ = at_s;
    ++rows_;
    const double piece = number(cells, *piece_, name_, line);
    std::optional<std::size_t> moved;
    std::int16_t counts = 0;
    for (const auto& [axis, column] : sticks_) {
      const double value = number(cells, column, name_, line);
      if (std::abs(value) > kTravel_counts) {
        fail(name_, line, "a stick travels 660 counts");
      }
      if (value != 0.0 && piece != 0.0) {
        if (moved) {
          fail(name_, line, "a piece moves one stick only");
        }
        moved = axis;
        counts = static_cast<std::int16_t>(std::lround(value));
      }
    }
    take(piece, moved, counts, line);
  }

 private:
  void take(double piece, std::optional<std::size_t> moved, std::int16_t counts, long line) {
    if (piece == 0.0) {
      last_piece_ = 0.0;
      return;
    }
    if (piece != last_piece_) {
      if (piece != std::floor(piece) || piece != static_cast<double>(out_.pieces.size() + 1)) {
        fail(name_, line, "'piece': must count up from 1, with 0 where the stick rests");
      }
      out_.pieces.push_back({.begin = out_.counts.size()});
      axis_.reset();
    }
    last_piece_ = piece;
    if (moved && axis_ && *axis_ != *moved) {
      fail(name_, line, "a piece moves one stick only");
    }
    axis_ = moved ? moved : axis_;
    ctl::ExcitationPiece& current = out_.pieces.back();
    current.axis = axis_ ? static_cast<ctl::ExcitedStick>(*axis_) : current.axis;
    ++current.count;
    out_.counts.push_back(counts);
  }

  ExcitationFile& out_;
  std::string name_;
  std::optional<std::size_t> time_, piece_, axis_;
  std::vector<std::pair<std::size_t, std::size_t>> sticks_;  ///< axis and column
  std::size_t rows_ = 0;
  double last_s_ = 0.0;
  double last_piece_ = 0.0;
};

void check(const ExcitationFile& out, const std::string& name) {
  if (out.pieces.empty()) {
    fail(name, 0, "no piece in it moves a stick; make it with m100-lab excite --out");
  }
  if (out.pieces.size() > kMaxPieces) {
    fail(name, 0, "more than " + std::to_string(kMaxPieces) + " pieces");
  }
  for (const ctl::ExcitationPiece& piece : out.pieces) {
    if (out.limits[static_cast<std::size_t>(piece.axis)].distance <= 0.0) {
      fail(name, 0,
           "no limits for " + std::string(companion::name(piece.axis)) + " in it; m100-lab excite writes them");
    }
    if (piece.count > std::numeric_limits<std::uint16_t>::max()) {
      fail(name, 0, "a piece is longer than 20 minutes");
    }
  }
}

}  // namespace

std::string_view name(ctl::ExcitedStick axis) { return kNames[static_cast<std::size_t>(axis)]; }

bool ExcitationFile::moves(ctl::ExcitedStick axis) const {
  return std::any_of(pieces.begin(), pieces.end(), [&](const ctl::ExcitationPiece& one) { return one.axis == axis; });
}

double ExcitationFile::length_s() const { return kPeriod_s * static_cast<double>(counts.size()); }

ExcitationFile parse_excitation(std::string_view text, const std::string& name) {
  ExcitationFile out;
  ExcitationParser rows(out, name);
  std::istringstream lines{std::string(text)};
  std::string line;
  for (long number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    if (line.front() == '#') {
      std::istringstream words(line.substr(1));
      if (std::string first; words >> first && first == "limits") {
        read_limits(words, out, name, number);
      }
    } else if (!rows.has_head()) {
      rows.head(cells_of(line), number);
    } else {
      rows.row(cells_of(line), number);
    }
  }
  check(out, name);
  return out;
}

std::string note_of(const ExcitationFile& excitation, const std::string& name) {
  std::ostringstream out;
  out.precision(17);
  for (std::size_t axis = 0; axis < ctl::kStickAxes; ++axis) {
    const ctl::ExcitationLimits& one = excitation.limits[axis];
    if (one.distance > 0.0) {
      out << "limits " << kNames[axis] << " distance " << one.distance << " braking " << one.braking << " speed "
          << one.speed << " tilt " << one.tilt_rad << "\n";
    }
  }
  for (const ctl::ExcitationPiece& piece : excitation.pieces) {
    out << companion::name(piece.axis);
    for (std::size_t k = 0; k < piece.count; ++k) {
      out << " " << excitation.counts[piece.begin + k];
    }
    out << "\n";
  }
  if (out.str().size() > kMaxNoteBytes) {
    fail(name, 0, "too long for one flight: the log could not hold it; fly it in two");
  }
  return out.str();
}

ExcitationFile excitation_of_note(const std::string& note) {
  constexpr const char* kName = "the log's excitation";
  ExcitationFile out;
  std::istringstream lines(note);
  std::string line;
  for (long number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "limits") {
      read_limits(words, out, kName, number);
      continue;
    }
    const std::optional<std::size_t> axis = axis_of(first);
    if (!axis) {
      fail(kName, number, "'" + first + "': no such stick");
    }
    out.pieces.push_back({.axis = static_cast<ctl::ExcitedStick>(*axis), .begin = out.counts.size()});
    for (int counts = 0; words >> counts;) {
      out.counts.push_back(static_cast<std::int16_t>(counts));
      ++out.pieces.back().count;
    }
  }
  check(out, kName);
  return out;
}

}  // namespace m100::companion
