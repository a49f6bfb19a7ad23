// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// What is wrong with a physics program or its answer, in one line.
class PhysicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// ArduPilot's JSON interface to physics programs (SIM_JSON): the servo packet, little endian, 40 bytes:
/// magic 18458 u16 | frame rate u16 | frame count u32 | 16 pulse widths u16 [us].
struct ServoPacket {
  static constexpr std::uint16_t kMagic = 18458;
  static constexpr std::size_t kBytes = 40;
  std::uint16_t rate_hz = 400;
  std::uint32_t frame = 0;
  std::array<std::uint16_t, 16> pulse_us{};
};
std::array<std::byte, ServoPacket::kBytes> encode(const ServoPacket& packet);

/// A physics program's answer, already in our frames (world NWU, body FLU).
struct PhysicsAnswer {
  double time_s = 0.0;  ///< of the physics program, absolute
  core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> velocity_w_m_s = core::Vector<double, 3>::Zero();
  core::Quaternion<double> rotation_wb{};
  core::Vector<double, 3> rate_b_rad_s = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> specific_force_b_m_s2 = core::Vector<double, 3>::Zero();
};

/// Reads a datagram: one JSON object (NED, FRD), with or without line feeds around it; of several lines the last
/// counts. The attitude may come as roll, pitch, yaw or as a quaternion, which wins. `velocity_wind` and `battery` may
/// be there: they are checked, and not used. Other fields are ignored.
/// @throws PhysicsError names the field that is missing, has another type, or is not a finite number.
PhysicsAnswer decode_answer(std::string_view datagram);

}  // namespace m100::sim
