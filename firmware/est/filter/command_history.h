// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/assert.h"
#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/command.h"
#include "firmware/est/filter/response_step.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

inline constexpr double kLargestAttitude_rad = 1.2;  ///< of attitudes and commands

/// Stores the commands of the last 0.64 s in the filter's axes. Returns those that act now, after each axis' transport
/// delay. T is float or double.
template <typename T>
class CommandHistory {
 public:
  explicit CommandHistory(const model::Vehicle& vehicle);

  /// Once per whole tick. A command that is not finite is replaced by the last finite one.
  /// @returns whether the command was finite
  bool store(const ctl::Command<T>& command, const core::SinCos<T>& heading);
  /// Delayed commands: the tilt that accelerates along x, the tilt that accelerates along y [rad], and the climb speed
  /// [m/s].
  ActingInputs<T> x() const { return acting(delay_x_, &PastCommand::x); }
  ActingInputs<T> y() const { return acting(delay_y_, &PastCommand::y); }
  ActingInputs<T> climb() const { return acting(delay_climb_, &PastCommand::climb); }

 private:
  struct PastCommand {
    T x{0}, y{0}, climb{0};
  };
  struct Delay {
    std::size_t ticks = 0;
    T rest{0};  ///< fraction of a tick
  };
  static constexpr std::size_t kCapacity = 64;

  static Delay delay_of(double delay_s);
  ActingInputs<T> acting(const Delay& delay, T PastCommand::*axis) const;

  Delay delay_x_, delay_y_, delay_climb_;
  std::array<PastCommand, kCapacity> past_{};
  std::size_t newest_ = 0;
  ctl::Command<T> last_{};
  core::CachedTilt<T> slope_;
};

extern template class CommandHistory<double>;
extern template class CommandHistory<float>;

}  // namespace m100::est
