// SPDX-License-Identifier: BSD-3-Clause
// Corrects an axis by a pose, records that for CovarianceInflation, and computes the reported estimate of an axis.
#include "firmware/core/maths.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/est/filter/units.h"

namespace m100::est {

template <typename S, typename Real>
void DisturbanceEkf<S, Real>::correct(AxisFilter<S>& filter, CovarianceInflation<Real>& lag,
                                      const typename AxisFilter<S>::PoseInnovation& test) {
  using Filter = AxisFilter<S>;
  constexpr Real kPerUnit = static_cast<Real>(1.0 / kTimeUnit_s);
  const auto real = [](S value) { return core::Arithmetic<S>::template real<Real>(value); };
  const Real position_m = real(filter.state(Filter::kP));
  const Real velocity = real(filter.state(Filter::kV));
  filter.fuse_pose(test);
  lag.update(real(test.innovation), real(filter.state(Filter::kP)) - position_m,
             (real(filter.state(Filter::kV)) - velocity) * kPerUnit, static_cast<Real>(test.normalised_square()),
             core::seconds<Real>(pose_.since_use));
}

template <typename S, typename Real>
AxisEstimate<Real> DisturbanceEkf<S, Real>::estimate_of(const AxisFilter<S>& f,
                                                        const CovarianceInflation<Real>& lag) const {
  using Filter = AxisFilter<S>;
  constexpr Real kPerUnit = static_cast<Real>(1.0 / kTimeUnit_s);
  constexpr Real kPerUnitSquared = static_cast<Real>(1.0 / (kTimeUnit_s * kTimeUnit_s));
  const auto real = [](S value) { return core::Arithmetic<S>::template real<Real>(value); };
  const auto covariance = [&](int row, int col) {
    const int scale = f.scales()[static_cast<std::size_t>(row)] + f.scales()[static_cast<std::size_t>(col)];
    return real(f.scaled_covariance(row, col)) * power_of_two<Real>(scale);
  };
  const Real tilt_rad = real(f.state(Filter::kTilt));
  const Real velocity_m_s = real(f.state(Filter::kV)) * kPerUnit;
  // A time of capture that is wrong by dt makes the position wrong by velocity dt, the velocity by acceleration dt.
  const Real way_m = velocity_m_s * pose_.time_sigma_s;
  const Real speed_change_m_s = static_cast<Real>(model::kGravity_m_s2) * tilt_rad * pose_.time_sigma_s;
  const Real own_m2 = covariance(Filter::kP, Filter::kP);
  const typename CovarianceInflation<Real>::Covariance inflated =
      lag.inflated({.pp_m2 = own_m2,
                    .pv_m2_s = covariance(Filter::kV, Filter::kP) * kPerUnit,
                    .vv_m2_s2 = covariance(Filter::kV, Filter::kV) * kPerUnitSquared},
                   core::seconds<Real>(pose_.age), core::seconds<Real>(pose_.since_use), pose_.acceleration_stored);
  return {.position_m = real(f.state(Filter::kP)),
          .velocity_m_s = velocity_m_s,
          .tilt_rad = tilt_rad,
          .tilt_rate_rad_s = real(f.state(Filter::kRate)) * kPerUnit,
          .disturbance_m_s2 = real(f.state(Filter::kD)) * kPerUnitSquared,
          .input_offset_rad = real(f.state(Filter::kM)),
          .position_variance_m2 = inflated.pp_m2 + way_m * way_m,
          .filter_variance_m2 = own_m2 + way_m * way_m,
          .position_velocity_m2_s = inflated.pv_m2_s,
          .velocity_variance_m2_s2 = inflated.vv_m2_s2 + speed_change_m_s * speed_change_m_s};
}

#define M100_AXIS_ESTIMATE_OF(S, Real)                                                           \
  template void DisturbanceEkf<S, Real>::correct(AxisFilter<S>&, CovarianceInflation<Real>&,     \
                                                 const typename AxisFilter<S>::PoseInnovation&); \
  template AxisEstimate<Real> DisturbanceEkf<S, Real>::estimate_of(const AxisFilter<S>&,         \
                                                                   const CovarianceInflation<Real>&) const;
M100_AXIS_ESTIMATE_OF(double, double)
M100_AXIS_ESTIMATE_OF(float, float)
M100_AXIS_ESTIMATE_OF(core::Fixed, float)
#undef M100_AXIS_ESTIMATE_OF

}  // namespace m100::est
