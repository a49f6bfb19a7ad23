// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// A movement of one stick, as an experimenter asks a pilot for it. The stick leaves its resting place by `counts` and
/// is back there afterwards.
struct N1StickMove {
  enum class Stick : std::uint8_t { kRoll, kPitch, kThrottle, kYaw };
  enum class Shape : std::uint8_t {
    kStep,     ///< there for `seconds`
    kDoublet,  ///< `seconds` to one side, as long to the other
    k3211,     ///< 3, 2, 1, 1 times `seconds`, to either side in turn
    kChirp,    ///< a sine from `from_hz` to `to_hz` within `seconds`
  };
  Stick stick = Stick::kRoll;
  Shape shape = Shape::kStep;
  double counts = 0.0;
  double seconds = 0.0;
  double from_hz = 0.0;
  double to_hz = 0.0;

  double length_s() const;
  /// Off the resting place, `t_s` after it began.
  double offset_counts(double t_s) const;
};

/// The pilot with his transmitter. He looks at the aircraft, brakes it, and holds the place where it stopped:
///
///   a_cmd = -2.0 v - 1.2 (p - p_stop) - 0.2 integral - a_air,   tilt = a_cmd / g, at most 25 degrees
///   climb = 1.0 (z_stop - z)
///
/// a_air is what he feels of the wind (the specific force across the thrust, with a time constant of 0.3 s). He learnt
/// his sticks on the measured aircraft; a plant with other scales is flown with those gains all the same. A stick that
/// he is asked to move does that and nothing else until the movement is over; then he flies back to his place.
class N1Pilot {
 public:
  /// @param resting where his sticks rest when he does not fly: the aircraft's balancing point.
  void set_resting(const StickInput& resting) { resting_ = resting; }
  const StickInput& resting() const { return resting_; }

  /// His sticks after `step` more of flying. Begins anew after stop().
  StickInput fly(const VehicleState& state, core::Duration step);
  /// From the next fly() on; what the stick did before is over.
  void move(const N1StickMove& move) { moves_[static_cast<std::size_t>(move.stick)] = {.move = move}; }
  /// Somebody else flies.
  void stop();

 private:
  using Vector2 = core::Vector<double, 2>;
  struct Moving {
    N1StickMove move{};
    double since_s = 0.0;
  };
  bool tilts() const;
  double flown(N1StickMove::Stick stick, double resting, double otherwise, double step_s);

  std::array<std::optional<Moving>, 4> moves_{};  ///< by stick
  StickInput resting_;
  std::optional<core::Vector<double, 3>> place_w_m_;
  Vector2 integral_w_ms_ = Vector2::Zero();
  std::optional<Vector2> air_w_m_s2_;
};

}  // namespace m100::sim
