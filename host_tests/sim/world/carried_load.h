// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"

namespace m100::sim {

/// What a payload does to the aircraft in addition to its weight: it swings on its cord, and it pulls the aircraft down
/// until the autopilot's thrust has followed.
class CarriedLoad {
 public:
  static constexpr double kHeightLoop_s = 0.1;  ///< until the autopilot's thrust has compensated a change of lift

  CarriedLoad() = default;
  explicit CarriedLoad(double carried_kg) : carried_before_kg_(carried_kg) {}

  /// Swings for a step. @param own acceleration of the aircraft without the load. @returns the acceleration by its
  /// pull;
  ///   zero without cord or load.
  core::Vector<double, 3> swing(double step_s, double cord_m, double carried_kg, double mass_kg,
                                const core::Vector<double, 3>& own);
  /// @returns the climb speed that is lost to a change of the load, after a step.
  double sag_m_s(double step_s, double carried_kg, double mass_kg);

 private:
  core::Vector<double, 3> offset_m_ = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> speed_m_s_ = core::Vector<double, 3>::Zero();
  double carried_before_kg_ = 0.0;
  double sag_m_s_ = 0.0;
};

}  // namespace m100::sim
