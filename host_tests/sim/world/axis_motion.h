// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/model/stick_axis.h"

namespace m100::sim {

/// The dynamics of one axis of the autopilot, from stick counts to angle (or rate, or climb speed). The command of the
/// stick comes from model::StickLaw, shared with identification; delay and dynamics are integrated here, separately.
/// Order: memory of the stick, delay | rest of the law, other axis, saturation | dynamics, lead zero, rate limit.
class AxisMotion {
 public:
  /// @param extra_delay_s of the command path, on top of the axis' own delay.
  explicit AxisMotion(const model::StickAxis& axis, double extra_delay_s = 0.0);

  /// A stick in counts of the Virtual RC (centre 1024), in force from now on.
  void set_stick(double counts);
  /// A command in the axis' own unit that bypasses the stick's law (movement control): delay and dynamics still apply.
  void set_direct(double command);

  /// Replaces the parameters of the axis; its present motion continues.
  void set_parameters(const model::StickAxis& axis);

  /// The law's output for the delayed input, before saturation: the input of the coupling to other axes.
  double commanded() const;
  /// Integrates one step (at most 10 ms; midpoint rule) towards commanded() + added.
  /// @param authority factor on bandwidth, 1 for a fresh battery and no payload.
  void advance(double step_s, double added, double authority = 1.0);

  double output() const { return output_; }
  double output_rate() const { return output_rate_; }

 private:
  struct Input {
    double since_s = 0.0;
    double value = 0.0;
    bool direct = false;
  };
  const Input& delayed() const;
  void store_input(double value, bool direct);

  static constexpr std::size_t kMaxInputs = 512;  ///< input changes kept, for delays far beyond any measured one
  model::StickAxis axis_;
  model::StickLaw<double> law_;
  model::ResponseLaw<double> response_;
  double extra_delay_s_;
  double delay_s_;
  double stick_counts_ = 0.0;  ///< the last stick, from neutral
  std::array<Input, kMaxInputs> inputs_{};
  std::size_t newest_ = 0;
  mutable std::size_t acting_ = 0;  ///< index into past_ of the delayed input; only ever moves forward
  double time_s_ = 0.0;
  double state_ = 0.0;
  double state_rate_ = 0.0;
  double output_ = 0.0;
  double output_rate_ = 0.0;
};

}  // namespace m100::sim
