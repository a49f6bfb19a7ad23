// SPDX-License-Identifier: BSD-3-Clause
// Uses the observer alone: it estimates a steady wind of 0.5 m/s^2 along x from attitude and pose. The aircraft leans
// against the wind and stands still.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/model/default_vehicle.h"

int main() {
  using m100::core::TimePoint;
  constexpr double kWind_m_s2 = 0.5;
  const double lean_rad = -std::atan(kWind_m_s2 / m100::model::kGravity_m_s2);
  const m100::model::Vehicle vehicle = m100::model::paper_vehicle();
  m100::est::DisturbanceEkf<double, double> observer(vehicle);
  m100::est::Estimate<double> estimate;
  for (int tick = 1; tick <= 3000; ++tick) {  // 30 s
    m100::est::Measurement<double> measured;
    measured.now = TimePoint(std::chrono::milliseconds(10 * tick));
    measured.attitude = {.is_new = true, .pitch_rad = lean_rad};
    if (tick % 2 == 0) {  // 50 poses a second
      measured.pose.is_new = true;
      measured.pose.sequence = static_cast<std::uint32_t>(tick / 2);
      measured.pose.arrived = measured.now;
      measured.pose.position_w_m = {1.0, -2.0, 1.5};
      measured.pose.set_captured_at(measured.now);
    }
    estimate = observer.update(measured, {.pitch_rad = lean_rad}, std::chrono::milliseconds(10));
  }
  std::printf("x %.3f m, y %.3f m, wind along x %.3f m/s^2\n", estimate.x.position_m, estimate.y.position_m,
              estimate.x.disturbance_m_s2);
  return estimate.healthy && std::abs(estimate.x.position_m - 1.0) < 0.01 &&
                 std::abs(estimate.x.disturbance_m_s2 - kWind_m_s2) < 0.05
             ? 0
             : 1;
}
