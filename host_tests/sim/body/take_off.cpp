// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/take_off.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/model/vehicle.h"
#include "host_tests/sim/body/sim_json.h"

namespace m100::sim {
namespace {

using Vector2 = core::Vector<double, 2>;
using Vector3 = core::Vector<double, 3>;

constexpr core::Duration kStep = std::chrono::microseconds(2500);
constexpr double kStep_s = 0.0025;
constexpr double kClimb_m_s = 0.8;
constexpr double kLongest_s = 60.0;
constexpr double kGusty_s = 20.0;
constexpr double kRests_s = 2.0;
constexpr double kNear_m = 0.1;
constexpr double kNear_m_s = 0.1;
constexpr double kGustyNear_m = 1.0;
constexpr double kTiltLimit_rad = 0.44;
constexpr double kAirFilter_s = 0.3;

/// The pilot's law (N1Pilot), towards a place that is given.
class PlaceHold {
 public:
  MovementInput fly(const VehicleState& state, const Vector3& place_w_m) {
    const double yaw_rad = core::yaw_of(state.rotation_wb);
    const Vector2 force_w = core::rotate_by_yaw(Vector2(state.specific_force_b_m_s2.head<2>()), yaw_rad);
    air_w_m_s2_ += kStep_s / kAirFilter_s * (force_w - air_w_m_s2_);
    const Vector2 away_m = (state.position_w_m - place_w_m).head<2>();
    integral_w_m_s_ += kStep_s * away_m.cwiseMax(-1.0).cwiseMin(1.0);
    const Vector2 wanted_w = -2.0 * Vector2(state.velocity_w_m_s.head<2>()) -
                             1.2 * away_m.cwiseMax(-3.0).cwiseMin(3.0) - 0.2 * integral_w_m_s_ - air_w_m_s2_;
    const Vector2 wanted_b = core::rotate_by_yaw(wanted_w, -yaw_rad);
    const auto tilt = [](double a_m_s2) {
      return std::clamp(std::atan(a_m_s2 / model::kGravity_m_s2), -kTiltLimit_rad, kTiltLimit_rad);
    };
    return {.roll_rad = tilt(-wanted_b.y()),
            .pitch_rad = tilt(wanted_b.x()),
            .climb_m_s = std::clamp(place_w_m.z() - state.position_w_m.z(), -kClimb_m_s, kClimb_m_s)};
  }

 private:
  Vector2 air_w_m_s2_ = Vector2::Zero();
  Vector2 integral_w_m_s_ = Vector2::Zero();
};

[[noreturn]] void fail(const VehicleState& state) {
  char text[200];
  std::snprintf(text, sizeof text,
                "the body did not reach its place within %.0f s of take-off: it is at x %.2f, y %.2f, z %.2f m; its "
                "motors, their order and [autopilot] must fit each other",
                kLongest_s, state.position_w_m.x(), state.position_w_m.y(), state.position_w_m.z());
  throw PhysicsError(text);
}

}  // namespace

void take_off(VehiclePort& body, const Vector3& place_w_m) {
  body.set_motors(true);
  PlaceHold hold;
  double rests_s = 0.0;
  double near_s = 0.0;
  for (double t_s = 0.0; rests_s < kRests_s && near_s < kGusty_s; t_s += kStep_s) {
    const VehicleState& state = body.state();
    // On the ground a tilt would tip it over.
    body.command(state.in_air ? hold.fly(state, place_w_m) : MovementInput{.climb_m_s = kClimb_m_s});
    body.advance(kStep);
    const double away_m = (state.position_w_m - place_w_m).norm();
    rests_s = away_m < kNear_m && state.velocity_w_m_s.norm() < kNear_m_s ? rests_s + kStep_s : 0.0;
    near_s = away_m < kGustyNear_m ? near_s + kStep_s : 0.0;
    if (t_s > kLongest_s || !(away_m < 1000.0)) {
      fail(state);
    }
  }
}

}  // namespace m100::sim
