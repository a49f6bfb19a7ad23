// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/assert.h"
#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/fixed_point.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/command.h"
#include "firmware/est/filter/axis_filter.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Stores the commands of the last 0.64 s in the filter's axes. Returns those that act now, after each axis' transport
/// delay.
template <typename S, typename Real>
class CommandHistory {
 public:
  explicit CommandHistory(const model::Vehicle& vehicle);

  /// Once per whole tick. A command that is not finite is replaced by the last finite one.
  /// @returns whether the command was finite
  bool store(const ctl::Command<Real>& command, const core::SinCos<Real>& heading);
  /// Delayed commands: the tilt that accelerates along x, the tilt that accelerates along y [rad], and the climb speed
  /// [m per unit of time].
  ActingInputs<S> x() { return acting(delay_x_, &PastCommand::x); }
  ActingInputs<S> y() { return acting(delay_y_, &PastCommand::y); }
  ActingInputs<S> climb() { return acting(delay_climb_, &PastCommand::climb); }
  std::uint32_t saturations() const { return arithmetic_.saturations(); }

 private:
  struct PastCommand {
    S x{}, y{}, climb{};
  };
  struct Delay {
    std::size_t ticks = 0;
    S rest{};  ///< fraction of a tick
  };
  static constexpr std::size_t kCapacity = 64;

  static Delay delay_of(double delay_s);
  const PastCommand& past(std::size_t ago) const {
    M100_ASSERT(ago < kCapacity);
    return past_[(newest_ + kCapacity - ago) % kCapacity];
  }
  ActingInputs<S> acting(const Delay& delay, S PastCommand::*axis);

  Delay delay_x_, delay_y_, delay_climb_;
  core::Arithmetic<S> arithmetic_;
  std::array<PastCommand, kCapacity> past_{};
  std::size_t newest_ = 0;
  ctl::Command<Real> last_{};
  core::CachedTilt<Real> slope_;
};

extern template class CommandHistory<double, double>;
extern template class CommandHistory<float, float>;
extern template class CommandHistory<core::Fixed, float>;

}  // namespace m100::est
