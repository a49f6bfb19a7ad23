// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/course/course_validation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {
namespace {

constexpr double kSlack = 1.01;
constexpr std::array<double, 3> kJoint{1e-3, 0.01, 0.05};  ///< largest jumps of value, first, second derivative

/// One limited quantity. `course_limit` is the limit of the course's own 'limits' lines.
struct Bound {
  const char* what;
  const char* unit;
  double scale;  ///< from SI to the unit
  double MotionMagnitudes::*value;
  double CourseLimits::*limit;
  double ref::SpeedLimits::*course_limit;
};
constexpr std::array kBounds{
    Bound{"speed", "m/s", 1.0, &MotionMagnitudes::speed_m_s, &CourseLimits::speed_m_s, &ref::SpeedLimits::speed_m_s},
    Bound{"acceleration", "m/s^2", 1.0, &MotionMagnitudes::acceleration_m_s2, &CourseLimits::acceleration_m_s2,
          &ref::SpeedLimits::acceleration_m_s2},
    Bound{"tilt", "deg", core::kRadian_deg, &MotionMagnitudes::tilt_rad, &CourseLimits::tilt_rad,
          &ref::SpeedLimits::tilt_rad},
    Bound{"climb speed", "m/s", 1.0, &MotionMagnitudes::climb_m_s, &CourseLimits::climb_m_s, nullptr},
    Bound{"yaw rate", "deg/s", core::kRadian_deg, &MotionMagnitudes::yaw_rate_rad_s, &CourseLimits::yaw_rate_rad_s,
          &ref::SpeedLimits::yaw_rate_rad_s}};

std::string three_digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

[[noreturn]] void refuse(const std::string& course, const CoursePiece& piece, const std::string& what) {
  throw CourseError(course + ":" + std::to_string(piece.line) + ": '" + piece.word + "': " + what);
}

ref::Motion standing(const ref::Motion& at) {
  ref::Motion out{};
  for (std::size_t d = 0; d < ref::kDimensions; ++d) {
    out[d][0] = at[d][0];
  }
  return out;
}

/// The lowest derivative (0: place) in which two motions differ, beginning with `from`; 3: none.
std::size_t difference(const ref::Motion& a, const ref::Motion& b, std::size_t from) {
  for (std::size_t order = from; order < kJoint.size(); ++order) {
    for (std::size_t d = 0; d < ref::kDimensions; ++d) {
      if (!(std::abs(a[d][order] - b[d][order]) <= kJoint[order])) {
        return order;
      }
    }
  }
  return kJoint.size();
}

void expect_joints(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                   const ref::Waypoint<double>& start, const std::string& course_name) {
  constexpr std::array<const char*, 3> kWhat{"place", "velocity", "acceleration"};
  ref::Motion before{};
  before[0][0] = start.position_w_m.x();
  before[1][0] = start.position_w_m.y();
  before[2][0] = start.position_w_m.z();
  before[3][0] = start.yaw_rad;
  for (const CoursePiece& piece : pieces) {
    const ref::Motion begins = course.motion(piece.begin);
    const bool jumps = piece.word == "step";
    const std::size_t order = difference(before, jumps ? standing(before) : begins, jumps ? 1 : 0);
    if (order < kJoint.size()) {
      refuse(course_name, piece,
             std::string(jumps ? "a step must begin at rest, but the course still has "
                               : "does not join the course before it in ") +
                 kWhat[order] + ", " + when_and_where(piece.begin, before, start));
    }
    before = course.motion(piece.end, true);
  }
  if (!pieces.empty() && difference(before, standing(before), 1) < kJoint.size()) {
    refuse(course_name, pieces.back(),
           "the course ends in motion, " + when_and_where(pieces.back().end, before, start));
  }
}

/// Refuses a jump that may exceed the speed limit. With full tilt for half of the way and full opposite tilt for the
/// other half, the aircraft reaches the root of acceleration times distance.
void expect_slow_jump(const ref::Motion& from, const ref::Motion& to, const CoursePiece& piece,
                      const CourseLimits& limits, const std::string& course_name) {
  const double way_m = std::hypot(to[0][0] - from[0][0], to[1][0] - from[1][0]);
  const double max_m_s2 = std::min(limits.acceleration_m_s2, model::kGravity_m_s2 * std::tan(limits.tilt_rad));
  const double reached_m_s = std::sqrt(way_m * max_m_s2);
  if (reached_m_s > kSlack * limits.speed_m_s) {
    refuse(course_name, piece,
           "the jump of " + three_digits(way_m) + " m reaches up to " + three_digits(reached_m_s) + " m/s, the limit " +
               three_digits(limits.speed_m_s) + " m/s: put 'limits speed_m_s " + three_digits(limits.speed_m_s) +
               "' above it");
  }
}

void expect_slow_jumps(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                       const ref::Waypoint<double>& start, const CourseLimits& limits, const std::string& course_name) {
  ref::Motion before{};
  before[0][0] = start.position_w_m.x();
  before[1][0] = start.position_w_m.y();
  for (const CoursePiece& piece : pieces) {
    if (piece.word == "step") {
      expect_slow_jump(before, course.motion(piece.begin), piece, limits, course_name);
    }
    before = course.motion(piece.end, true);
  }
}

}  // namespace

MotionMagnitudes magnitudes_of(const ref::Motion& motion) {
  const auto& [x, y, z, yaw] = motion;
  return {.speed_m_s = std::hypot(x[1], y[1], z[1]),
          .acceleration_m_s2 = std::hypot(x[2], y[2], z[2]),
          .tilt_rad = ref::tilt_of(x[2], y[2], z[2]),
          .climb_m_s = std::abs(z[1]),
          .yaw_rate_rad_s = std::abs(yaw[1])};
}

void for_each_sample(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                     const std::function<void(const CoursePiece&, core::Duration, const ref::Motion&)>& look) {
  constexpr core::Duration::rep kMaxSamplesPerPiece = 4000;
  for (const CoursePiece& piece : pieces) {
    const core::Duration length = piece.end - piece.begin;
    const core::Duration::rep count =
        std::clamp<core::Duration::rep>(length / core::kTickPeriod + 1, 1, kMaxSamplesPerPiece);
    for (core::Duration::rep i = 0; i <= count; ++i) {
      const core::Duration at = piece.begin + length * i / count;
      look(piece, at, course.motion(at, i == count));
    }
  }
}

std::string when_and_where(core::Duration at, const ref::Motion& motion, const ref::Waypoint<double>& start) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%.2f s after the beginning, at (%.2f, %.2f, %.2f) m from the start",
                core::seconds<double>(at), motion[0][0] - start.position_w_m.x(), motion[1][0] - start.position_w_m.y(),
                motion[2][0] - start.position_w_m.z());
  return text.data();
}

void validate_course(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                     const ref::Waypoint<double>& start, const CourseLimits& limits, const std::string& course_name) {
  expect_joints(course, pieces, start, course_name);
  expect_slow_jumps(course, pieces, start, limits, course_name);
  for_each_sample(course, pieces, [&](const CoursePiece& piece, core::Duration at, const ref::Motion& motion) {
    const MotionMagnitudes effort = magnitudes_of(motion);
    for (const Bound& bound : kBounds) {
      const double value = effort.*bound.value;
      const bool own = bound.course_limit != nullptr && piece.limits.*bound.course_limit < limits.*bound.limit;
      const double limit = own ? piece.limits.*bound.course_limit : limits.*bound.limit;
      if (value > kSlack * limit) {
        refuse(course_name, piece,
               std::string("the ") + bound.what + " is " + three_digits(value * bound.scale) + " " + bound.unit +
                   ", the " + (own ? "course's own " : "") + "limit " + three_digits(limit * bound.scale) + " " +
                   bound.unit + ", " + when_and_where(at, motion, start));
      }
    }
  });
}

}  // namespace m100::companion
