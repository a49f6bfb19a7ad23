// SPDX-License-Identifier: BSD-3-Clause
// Who lies where the attitude does not answer our commands: one witness is too few, and the poses are a second one.
#include "firmware/app/pose_trust.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::app {
namespace {

using Vector2 = core::Vector<double, 2>;

/// Braking to and fro about both axes, as fast as a loop swings.
Vector2 asked_rad(double t_s) { return {0.1 * std::sin(2.5 * t_s), 0.08 * std::cos(3.1 * t_s)}; }

/// Four seconds of an attitude that is the opposite of what is asked, while nothing is felt and the observer stands.
/// @param toward_m how far the poses are where the commands lead, from where the observer is; negative: where the
///   attitude leads
/// @returns the check that objects at the end
est::Check after(double toward_m) {
  PoseTrust<double> trust({});
  for (int tick = 1; tick <= 400; ++tick) {
    const Vector2 asked = asked_rad(0.01 * tick);
    est::Estimate<double> estimate;
    estimate.x.tilt_rad = -asked.x();
    estimate.y.tilt_rad = -asked.y();
    est::Measurement<double> measured;
    measured.now = core::TimePoint(core::kTickPeriod * tick);
    measured.pose.is_new = true;
    measured.pose.set_captured_at(measured.now);
    const Vector2 lead(asked.x(), -asked.y());  // tilt about x moves along x, about y against y
    measured.pose.position_w_m.head<2>() = toward_m * lead.normalized();
    trust.update({}, measured, estimate, asked, safety::Rung::kNominal, core::kTickPeriod);
  }
  return trust.contradiction().check;
}

// Would catch one that believes the attitude until something else accuses it, too: the force goes with an attitude that
// lies from the beginning, and the observer with both.
TEST(PoseTrust, PosesWhereTheCommandsLeadAccuseAnAttitudeThatDoesNotAnswer) {
  RecordProperty("promise", "R14");
  EXPECT_EQ(after(0.5), est::Check::kAnswer);
}

TEST(PoseTrust, AnAttitudeThatDoesNotAnswerIsNotAccusedByItself) {
  RecordProperty("promise", "R17");
  EXPECT_EQ(after(0.0), est::Check::kNone);
  EXPECT_EQ(after(0.04), est::Check::kNone) << "as far as a lag behind gusts";
  EXPECT_EQ(after(-0.5), est::Check::kNone) << "the poses are where the attitude leads";
}

}  // namespace
}  // namespace m100::app
