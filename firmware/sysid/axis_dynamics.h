// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/stick_axis.h"

namespace m100::sysid {

/// Response of an axis to its command, exact for a command held over one sample period (model::AxisStep; the caller
/// applies the lead zero to the command), and behind it the effects of model::ResponseLaw. Second order: state (y, y').
template <typename Real>
class AxisDynamics {
 public:
  /// Requires what model::axis_step() requires.
  AxisDynamics(const model::StickAxis& axis, Real sample_period_s);
  void start(Real value, Real rate_per_s);
  /// Holds `command` for one sample period.
  /// @returns the response at its end.
  Real step(Real command) {
    const Real before = value_;
    if (first_order_) {
      value_ = command + a11_ * (value_ - command);
      if (law_.acts()) {
        value_ = law_.value(before, value_, sample_period_s_);
      }
      return value_;
    }
    const Real offset = value_ - command;
    value_ = command + a11_ * offset + a12_ * rate_per_s_;
    rate_per_s_ = a21_ * offset + a22_ * rate_per_s_;
    if (law_.acts()) {
      rate_per_s_ = law_.rate(rate_per_s_);
      value_ = law_.value(before, value_, sample_period_s_);
    }
    return value_;
  }
  Real value() const { return value_; }
  Real rate_per_s() const { return rate_per_s_; }

 private:
  bool first_order_;
  Real sample_period_s_;
  model::ResponseLaw<Real> law_;
  Real a11_ = Real(0), a12_ = Real(0), a21_ = Real(0), a22_ = Real(0);
  Real value_ = Real(0), rate_per_s_ = Real(0);
};

}  // namespace m100::sysid
