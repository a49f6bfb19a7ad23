// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_dynamics.h"

#include "firmware/core/maths.h"
#include "firmware/model/axis_step.h"

namespace m100::sysid {

template <typename Real>
[[gnu::cold]] AxisDynamics<Real>::AxisDynamics(const model::StickAxis& axis, Real sample_period_s)
    : first_order_(axis.is_first_order()),
      sample_period_s_(sample_period_s),
      limit_per_s_(static_cast<Real>(axis.rate_limit_per_s)) {
  const model::AxisStep step = model::axis_step(axis, static_cast<double>(sample_period_s));
  a11_ = static_cast<Real>(step.oo);
  a12_ = static_cast<Real>(step.o_r);
  a21_ = static_cast<Real>(step.ro);
  a22_ = static_cast<Real>(step.rr);
}

template <typename Real>
void AxisDynamics<Real>::start(Real value, Real rate_per_s) {
  value_ = value;
  rate_per_s_ = limit_per_s_ > Real(0) ? core::clamp(rate_per_s, -limit_per_s_, limit_per_s_) : rate_per_s;
}

template <typename Real>
Real AxisDynamics<Real>::limited(Real before, Real after) const {
  const Real most = limit_per_s_ * sample_period_s_;
  return before + core::clamp(after - before, -most, most);
}

template <typename Real>
void AxisDynamics<Real>::limit_rate(Real before) {
  rate_per_s_ = core::clamp(rate_per_s_, -limit_per_s_, limit_per_s_);
  value_ = limited(before, value_);
}

template class AxisDynamics<float>;
template class AxisDynamics<double>;

}  // namespace m100::sysid
