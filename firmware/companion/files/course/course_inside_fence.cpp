// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/course/course_inside_fence.h"

#include "firmware/companion/files/text/toml_text.h"

namespace m100::companion {
namespace {

constexpr double kRounding_m = 1e-3;  ///< poses are exact to millimetres; a course along the fence counts as inside

/// One axis of a place, and the fence's range on this axis.
struct Side {
  const char* axis;
  double at_m;
  Range box;
};

}  // namespace

void validate_inside_fence(const FlightFile& flight, const ref::Waypoint<double>& start,
                           const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                           const std::string& course_name) {
  const auto expect = [&](const core::Vector<double, 3>& place_w_m, const auto& who, const auto& when) {
    const core::Vector<double, 3> offset_m = place_w_m - start.position_w_m;
    for (const Side& side : {Side{"x", offset_m.x(), flight.fence_x_m}, Side{"y", offset_m.y(), flight.fence_y_m},
                             Side{"z", place_w_m.z(), flight.fence_z_m}}) {
      if (!Range{side.box.low - kRounding_m, side.box.high + kRounding_m}.contains(side.at_m)) {
        throw FileError(who() + ": " + side.axis + " = " + text_of(side.at_m) + " m is outside the fence, " +
                        side.axis + "_m = " + text_of(side.box) + when());
      }
    }
  };
  expect(
      start.position_w_m, [] { return std::string("the start of the flight"); }, [] { return std::string(); });
  for_each_sample(course, pieces, [&](const CoursePiece& piece, core::Duration at, const ref::Motion& motion) {
    expect(
        {motion[0][0], motion[1][0], motion[2][0]},
        [&] { return course_name + ":" + std::to_string(piece.line) + ": '" + piece.word + "'"; },
        [&] { return ", " + when_and_where(at, motion, start); });
  });
}

}  // namespace m100::companion
