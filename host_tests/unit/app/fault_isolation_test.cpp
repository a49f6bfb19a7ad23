// SPDX-License-Identifier: BSD-3-Clause
// Which sensor is wrong if the attitude does not follow our commands? That alone does not decide it; the poses are a
// second witness.
#include "firmware/app/fault_isolation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::app {
namespace {

using Vector2 = core::Vector<double, 2>;

/// Commands that alternate on both axes, as fast as an oscillating loop.
Vector2 model_tilt_rad(double t_s) { return {0.1 * std::sin(2.5 * t_s), 0.08 * std::cos(3.1 * t_s)}; }

/// Runs four seconds in which the attitude is the opposite of the command, no force is measured, and the observer
/// stands still.
/// @param toward_m how far the poses are from the observer's position, in the direction of the commands; negative: in
///   the direction of the attitude
/// @returns the check that objects at the end
est::ConsistencyCheck after(double toward_m) {
  FaultIsolation<double> trust({});
  for (int tick = 1; tick <= 400; ++tick) {
    const Vector2 asked = model_tilt_rad(0.01 * tick);
    est::Estimate<double> estimate;
    estimate.x.tilt_rad = -asked.x();
    estimate.y.tilt_rad = -asked.y();
    est::Measurement<double> measured;
    measured.now = core::TimePoint(core::kTickPeriod * tick);
    measured.pose.is_new = true;
    measured.pose.set_captured_at(measured.now);
    const Vector2 lead(asked.x(), -asked.y());  // tilt.x accelerates along x, tilt.y against y
    measured.pose.position_w_m.head<2>() = toward_m * lead.normalized();
    trust.update({}, measured, estimate, asked, safety::FailsafeState::kNominal, core::kTickPeriod);
  }
  return trust.contradiction().check;
}

// Would catch a FaultIsolation that needs a further objection before it rejects the attitude: force and observer both
// follow an attitude that is wrong from the beginning.
TEST(FaultIsolation, PosesWhereTheCommandsLeadAccuseAnAttitudeThatDoesNotAnswer) {
  RecordProperty("promise", "R14");
  EXPECT_EQ(after(0.5), est::ConsistencyCheck::kAnswer);
}

TEST(FaultIsolation, AnAttitudeThatDoesNotAnswerIsNotAccusedByItself) {
  RecordProperty("promise", "R17");
  EXPECT_EQ(after(0.0), est::ConsistencyCheck::kNone);
  EXPECT_EQ(after(0.04), est::ConsistencyCheck::kNone) << "as far as a lag behind gusts";
  EXPECT_EQ(after(-0.5), est::ConsistencyCheck::kNone) << "the poses are where the attitude leads";
}

}  // namespace
}  // namespace m100::app
