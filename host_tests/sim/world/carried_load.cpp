// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/carried_load.h"

#include <cmath>

#include "firmware/model/vehicle.h"

namespace m100::sim {
namespace {

constexpr double kCordDamping_per_s = 0.1;
constexpr double kHeightRecovers_s = 0.3;  // of the climb speed that was lost while the thrust followed

}  // namespace

core::Vector<double, 3> CarriedLoad::swing(double step_s, double cord_m, double carried_kg, double mass_kg,
                                           const core::Vector<double, 3>& own) {
  if (cord_m <= 0.0 || carried_kg <= 0.0) {
    return core::Vector<double, 3>::Zero();
  }
  const double stiffness = model::kGravity_m_s2 / cord_m;
  core::Vector<double, 3> pull = stiffness * offset_m_ * (carried_kg / mass_kg);
  core::Vector<double, 3> relative = -stiffness * offset_m_ - kCordDamping_per_s * speed_m_s_ - own - pull;
  relative.z() = 0.0;
  speed_m_s_ += step_s * relative;
  offset_m_ += step_s * speed_m_s_;
  return pull;
}

double CarriedLoad::sag_m_s(double step_s, double carried_kg, double mass_kg) {
  if (carried_kg != carried_before_kg_) {
    sag_m_s_ -= kHeightLoop_s * model::kGravity_m_s2 * (carried_kg - carried_before_kg_) / (mass_kg + carried_kg);
    carried_before_kg_ = carried_kg;
  }
  sag_m_s_ *= std::exp(-step_s / kHeightRecovers_s);
  return sag_m_s_;
}

}  // namespace m100::sim
