// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_dynamics.h"

#include "firmware/model/axis_step.h"

namespace m100::sysid {

template <typename Real>
[[gnu::cold]] AxisDynamics<Real>::AxisDynamics(const model::StickAxis& axis, Real sample_period_s)
    : first_order_(axis.is_first_order()), sample_period_s_(sample_period_s), law_(axis) {
  const model::AxisStep step = model::axis_step(axis, static_cast<double>(sample_period_s));
  a11_ = static_cast<Real>(step.oo);
  a12_ = static_cast<Real>(step.o_r);
  a21_ = static_cast<Real>(step.ro);
  a22_ = static_cast<Real>(step.rr);
}

template <typename Real>
void AxisDynamics<Real>::start(Real value, Real rate_per_s) {
  value_ = value;
  rate_per_s_ = law_.rate(rate_per_s);
}

template class AxisDynamics<float>;
template class AxisDynamics<double>;

}  // namespace m100::sysid
