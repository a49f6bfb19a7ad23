// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// A movement of one stick in an experiment. The stick leaves its resting position by `counts` and returns afterwards.
struct N1StickMove {
  enum class Stick : std::uint8_t { kRoll, kPitch, kThrottle, kYaw };
  enum class Shape : std::uint8_t {
    kStep,     ///< deflected for `seconds`
    kDoublet,  ///< `seconds` to one side, as long to the other
    k3211,     ///< 3, 2, 1, 1 times `seconds`, to alternating sides
    kChirp,    ///< a sine from `from_hz` to `to_hz` within `seconds`
  };
  Stick stick = Stick::kRoll;
  Shape shape = Shape::kStep;
  double counts = 0.0;
  double seconds = 0.0;
  double from_hz = 0.0;
  double to_hz = 0.0;

  double length_s() const;
  /// Deflection from the resting position, `t_s` after the movement began.
  double offset_counts(double t_s) const;
};

/// The pilot with his transmitter. He sees the aircraft, brakes it, and holds the place where it stopped:
///
///   a_cmd = -2.0 v - 1.2 (p - p_stop) - 0.2 integral - a_air,   tilt = a_cmd / g, at most 25 degrees
///   climb = 1.0 (z_stop - z)
///
/// a_air is his estimate of the wind's force (the specific force across the thrust, with a time constant of 0.3 s). His
/// gains fit the measured aircraft and stay the same on a plant with other scales. During a scripted movement a stick
/// does nothing else; afterwards he flies back to his place.
class N1Pilot {
 public:
  /// @param resting position of his sticks while he does not fly: the aircraft's trim.
  void set_resting(const StickInput& resting) { resting_ = resting; }
  const StickInput& resting() const { return resting_; }

  /// His sticks after a further `step` of flying. Starts from the present place after stop().
  StickInput fly(const VehicleState& state, core::Duration step);
  /// Starts a movement at the next fly(); it replaces an earlier movement of the stick.
  void move(const N1StickMove& move) { moves_[static_cast<std::size_t>(move.stick)] = {.move = move}; }
  /// Ends his flying: another command is in force.
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
