// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/course/course.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "firmware/companion/files/course/course_line.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {
namespace {

constexpr double kSamePlace_m = 1e-3;
constexpr std::string_view kTable = "t_s";
constexpr core::Duration kHour = std::chrono::hours(1);

/// Builds a course line by line.
template <typename T>
class CourseBuilder {
 public:
  CourseBuilder(const ref::Waypoint<T>& start, ref::Trajectory<T>& course, const std::string& name)
      : start_(start), course_(course), name_(name) {
    course.hold(start);
  }

  void line(const std::string& text, int number) {
    const std::vector<std::string> words = split(text, ' ');
    if (words.empty()) {
      return;
    }
    if (words[0].starts_with(kTable) && text.find(',') != std::string::npos) {
      end_run();
      table_.begin(split(text, ','), {name_, number, std::string(kTable)});
    } else if (table_.is_open() && text.find(',') != std::string::npos) {
      row(split(text, ','), {name_, number, std::string(kTable)});
    } else {
      word(words, {name_, number, words[0]});
    }
  }

  std::vector<CoursePiece> finish() {
    end_run();
    return std::move(pieces_);
  }

 private:
  using Words = std::vector<std::string>;
  struct Entry {
    std::string_view word;
    core::Status (CourseBuilder::*lay)(const Words&, const FilePosition&);
  };
  void word(const Words& words, const FilePosition& spot) {
    if (spot.word == "through") {
      end_table();
      const std::vector<double> n = numbers(words, 4, spot);
      through_.push_back(turned_place(n, spot));
      spots_.push_back(spot);
      return;
    }
    end_run();
    if (spot.word == "limits") {
      read_limits(words, spot, limits_, named_);
      return;
    }
    constexpr std::array kPieces{
        Entry{"step", &CourseBuilder::step},     Entry{"quintic", &CourseBuilder::quintic},
        Entry{"square", &CourseBuilder::square}, Entry{"circle", &CourseBuilder::circle},
        Entry{"eight", &CourseBuilder::eight},   Entry{"polynomial", &CourseBuilder::polynomial}};
    const auto* const entry =
        std::find_if(kPieces.begin(), kPieces.end(), [&](const Entry& row) { return row.word == spot.word; });
    if (entry == kPieces.end()) {
      const bool table = spot.word.find_first_of(",;\"") != std::string::npos;
      spot.fail(table ? "no such piece; a table begins with t_s,x_m,y_m,z_m, without quotation marks"
                      : "no such piece" + did_you_mean(spot.word, kCourseWords, &CourseWord::word));
    }
    const core::Duration begin = course_.duration();
    const core::Status status = (this->*entry->lay)(words, spot);
    if (status != core::Status::kOk) {
      spot.fail(reason(status));
    }
    note(spot, begin, course_.duration());
  }

  core::Status step(const Words& words, const FilePosition& spot) {
    const std::vector<double> n = numbers(words, 5, spot);
    const ref::Waypoint<T> there = turned_place(n, spot);
    const core::Duration lasts = seconds_of(n[4], spot);
    const bool stands = there.position_w_m == course_.end().position_w_m && there.yaw_rad == course_.end().yaw_rad;
    return is_limited() && !stands ? step_within_limits(there, lasts, spot) : course_.append_step(there, lasts);
  }

  /// Replaces the jump of a 'step' line by a way within the limits, and stays there for the rest of the line's time.
  /// Fails if the way takes as long as the line, or longer.
  core::Status step_within_limits(const ref::Waypoint<T>& there, core::Duration lasts, const FilePosition& spot) {
    ref::SpeedLimits limits = limits_;
    limits.acceleration_m_s2 =
        std::min(limits.acceleration_m_s2, model::kGravity_m_s2 * std::sin(std::min(limits.tilt_rad, 0.5 * core::kPi)));
    const core::Duration begin = course_.duration();
    const core::Status status = course_.append_quintic(there, limits);
    const core::Duration way = course_.duration() - begin;
    if (status == core::Status::kOk && way >= lasts) {
      std::ostringstream what;
      what << "the way takes " << core::seconds<double>(way) << " s within its limits, but the line allows "
           << core::seconds<double>(lasts) << " s";
      spot.fail(what.str());
    }
    return status == core::Status::kOk ? course_.append_step(there, lasts - way) : status;
  }
  bool is_limited() const { return std::min({named_.speed_m_s, named_.acceleration_m_s2, named_.tilt_rad}) < kNoLimit; }
  core::Status quintic(const Words& words, const FilePosition& spot) {
    const std::vector<double> n = numbers(words, 5, spot);
    return course_.append_quintic(turned_place(n, spot), seconds_of(n[4], spot));
  }
  core::Status square(const Words& words, const FilePosition& spot) {
    const std::vector<double> n = numbers(words, 3, spot);
    return course_.append_square(static_cast<T>(n[0]), seconds_of(n[1], spot), seconds_of(n[2], spot));
  }
  core::Status circle(const Words& words, const FilePosition& spot) {
    const std::vector<double> n = numbers(words, 3, spot);
    return course_.append_curve(ref::Curve::circle(n[0], n[1], n[2]), limits_);
  }
  core::Status eight(const Words& words, const FilePosition& spot) {
    const std::vector<double> n = numbers(words, 4, spot);
    return course_.append_curve(ref::Curve::figure_of_eight(n[0], n[1], n[2], n[3]), limits_);
  }

  core::Status polynomial(const Words& words, const FilePosition& spot) {
    constexpr std::array<std::string_view, ref::kDimensions> kAxes{"x", "y", "z", "yaw"};
    if (words.size() < 4) {
      spot.fail("needs a time, an axis (x, y, z, yaw) and its coefficients");
    }
    const double duration_s = number(words[1], spot);
    const std::array<double, ref::kDimensions> origin = offset(start_);
    std::array<ref::Polynomial<double>, ref::kDimensions> axes{};
    const std::array<double, ref::kDimensions> here = offset(course_.end());
    for (std::size_t d = 0; d < ref::kDimensions; ++d) {
      axes[d].c[0] = here[d];  // an axis that is not named keeps its value
    }
    std::size_t axis = kAxes.size(), count = 0;
    double scale = 1.0;
    for (std::size_t i = 2; i < words.size(); ++i) {
      const auto* const named = std::find(kAxes.begin(), kAxes.end(), words[i]);
      if (named != kAxes.end()) {
        axis = static_cast<std::size_t>(named - kAxes.begin());
        count = 0;
        scale = 1.0;
        continue;
      }
      if (axis == kAxes.size()) {
        spot.fail("'" + words[i] + "' is not an axis; the axes are x, y, z, yaw" + did_you_mean(words[i], kAxes));
      }
      if (count == ref::kCoefficients) {
        spot.fail("has more than 8 coefficients for " + std::string(kAxes[axis]));
      }
      axes[axis].c[count] = number(words[i], spot) * scale + (count == 0 ? origin[axis] : 0.0);
      scale *= duration_s;
      ++count;
    }
    return course_.append_polynomial(axes, seconds_of(duration_s, spot));
  }

  void row(const Words& values, const FilePosition& spot) {
    const auto [position_m, yaw_rad, at_s] = table_.row(values, spot);
    const ref::Waypoint<T> there = place({position_m[0], position_m[1], position_m[2], yaw_rad});
    if (at_s == 0.0 && timed_.empty()) {  // the row only repeats where the course is
      if ((there.position_w_m - course_.end().position_w_m).norm() > static_cast<T>(kSamePlace_m)) {
        spot.fail("the table does not begin where the course is; give its first row a time above 0");
      }
      return;
    }
    const core::Duration at = seconds_of(at_s, spot);
    const core::Duration before = timed_.empty() ? core::Duration{0} : timed_.back().at;
    if (at - before < ref::kMinWaypointSpacing || at - before > kHour) {
      spot.fail(reason(core::Status::kInvalidArgument));
    }
    timed_.push_back({.place = there, .at = at});
    spots_.push_back(spot);
  }

  void end_table() {
    if (!timed_.empty()) {
      laid(course_.append_timed(std::span<const ref::TimedWaypoint<T>>(timed_)));
      timed_.clear();
    }
    table_.end();
  }

  /// Appends the waypoints of 'through' lines or of a table that were collected.
  void end_run() {
    end_table();
    if (!through_.empty()) {
      laid(course_.append_minimum_snap(std::span<const ref::Waypoint<T>>(through_), limits_));
      through_.clear();
    }
  }

  void laid(core::Status status) {
    if (status != core::Status::kOk) {
      spots_.front().fail(reason(status));
    }
    const std::size_t first = course_.pieces() - spots_.size();
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      note(spots_[i], first + i == 0 ? core::Duration{0} : course_.piece_end(first + i - 1),
           course_.piece_end(first + i));
    }
    spots_.clear();
  }

  void note(const FilePosition& spot, core::Duration begin, core::Duration end) {
    pieces_.push_back({spot.line, spot.word, begin, end, named_});
  }

  static std::array<double, ref::kDimensions> offset(const ref::Waypoint<T>& place) {
    return {static_cast<double>(place.position_w_m.x()), static_cast<double>(place.position_w_m.y()),
            static_cast<double>(place.position_w_m.z()), static_cast<double>(place.yaw_rad)};
  }

  /// The place n = X, Y, Z, YAW of a line. No line needs more than a turn, so a larger heading was meant in degrees.
  ref::Waypoint<T> turned_place(const std::vector<double>& n, const FilePosition& spot) const {
    if (!core::is_within_turn(n[3])) {
      std::ostringstream what;
      what << "the heading is in rad, and " << n[3] << " is more than a turn: " << n[3] << " degrees are "
           << n[3] * core::kDegree_rad;
      spot.fail(what.str());
    }
    return place(n);
  }

  ref::Waypoint<T> place(const std::vector<double>& n) const {
    ref::Waypoint<T> out = start_;
    for (Eigen::Index i = 0; i < 3; ++i) {
      out.position_w_m[i] += static_cast<T>(n[static_cast<std::size_t>(i)]);
    }
    out.yaw_rad += static_cast<T>(n[3]);
    return out;
  }

  const ref::Waypoint<T>& start_;
  ref::Trajectory<T>& course_;
  const std::string& name_;
  ref::SpeedLimits limits_;
  ref::SpeedLimits named_ = kNoLimits;  ///< only those that 'limits' lines give
  std::vector<CoursePiece> pieces_;
  std::vector<ref::Waypoint<T>> through_;
  CourseTable table_;  ///< being read
  std::vector<ref::TimedWaypoint<T>> timed_;
  std::vector<FilePosition> spots_;  ///< of the waypoints not yet appended
};

}  // namespace

std::string course_help() {
  std::string help =
      "A course file has one piece per line; places are offsets from the start [m, rad], along the axes of the "
      "world:\n";
  for (const CourseWord& word : kCourseWords) {
    help += "  " + std::string(word.word) + (word.arguments.empty() ? "" : " ") + std::string(word.arguments) +
            "\n      " + std::string(word.sentence) + "\n";
  }
  return help;
}

template <typename T>
std::vector<CoursePiece> parse_course(std::string_view text, const ref::Waypoint<T>& start, ref::Trajectory<T>& course,
                                      const std::string& name) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write it
  text.remove_prefix(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
  CourseBuilder<T> layer(start, course, name);
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    layer.line(line.substr(0, line.find('#')), number);
  }
  return layer.finish();
}

template std::vector<CoursePiece> parse_course<float>(std::string_view, const ref::Waypoint<float>&,
                                                      ref::Trajectory<float>&, const std::string&);
template std::vector<CoursePiece> parse_course<double>(std::string_view, const ref::Waypoint<double>&,
                                                       ref::Trajectory<double>&, const std::string&);

}  // namespace m100::companion
