// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/sim_json.h"

#include <cmath>
#include <string>

#include "firmware/companion/files/text/json.h"

namespace m100::sim {
namespace {

using Vector3 = core::Vector<double, 3>;

constexpr double kMaxNormError = 0.05;  // of a quaternion: a rounded one passes, four other numbers do not

template <typename Number, typename Bytes>
void put(Number value, Bytes& bytes, std::size_t& at) {
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    bytes[at++] = static_cast<std::byte>(value >> (8U * i) & 0xFFU);
  }
}

/// The last line that is not blank, without the blanks around it.
std::string_view last_line(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t end = text.find_last_not_of(std::string_view(" \t\r\n\0", 5));
  if (end == std::string_view::npos) {
    return {};
  }
  text = text.substr(0, end + 1);
  const std::size_t line = text.rfind('\n');
  text = line == std::string_view::npos ? text : text.substr(line + 1);
  return text.substr(std::min(text.find_first_not_of(kBlank), text.size()));
}

const Json& field(const Json& in, const char* key, const std::string& name) {
  const auto found = in.find(key);
  if (found == in.end()) {
    throw PhysicsError("the answer has no '" + name + "'");
  }
  return *found;
}

double number(const Json& value, const std::string& name) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw PhysicsError("'" + name + "' is not a finite number");
  }
  return value.get<double>();
}

template <std::size_t kCount>
std::array<double, kCount> numbers(const Json& value, const std::string& name) {
  if (!value.is_array() || value.size() != kCount) {
    throw PhysicsError("'" + name + "' is not a list of " + std::to_string(kCount) + " numbers");
  }
  std::array<double, kCount> out{};
  for (std::size_t i = 0; i < kCount; ++i) {
    out[i] = number(value[i], name);
  }
  return out;
}

/// A vector in NED or FRD, in our frames.
Vector3 vector(const Json& in, const char* key, const std::string& name) {
  const std::array<double, 3> v = numbers<3>(field(in, key, name), name);
  return core::flip_yz(Vector3(v[0], v[1], v[2]));
}

core::Quaternion<double> rotation(const Json& in) {
  if (const auto found = in.find("quaternion"); found != in.end()) {
    const std::array<double, 4> q = numbers<4>(*found, "quaternion");
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (std::abs(norm - 1.0) > kMaxNormError) {
      throw PhysicsError("'quaternion' does not have the length 1");
    }
    return core::flip_yz(
        core::Quaternion<double>{.w = q[0] / norm, .x = q[1] / norm, .y = q[2] / norm, .z = q[3] / norm});
  }
  if (!in.contains("attitude")) {
    throw PhysicsError("the answer has neither 'attitude' nor 'quaternion'");
  }
  const std::array<double, 3> angles = numbers<3>(in["attitude"], "attitude");
  return core::flip_yz(
      core::quaternion_of(core::Euler<double>{.roll_rad = angles[0], .pitch_rad = angles[1], .yaw_rad = angles[2]}));
}

void check_optional(const Json& in) {
  if (const auto wind = in.find("velocity_wind"); wind != in.end()) {
    static_cast<void>(numbers<3>(*wind, "velocity_wind"));
  }
  const auto battery = in.find("battery");
  for (const char* const key : {"voltage", "current"}) {
    if (battery != in.end() && battery->is_object() && battery->contains(key)) {
      static_cast<void>(number((*battery)[key], std::string("battery.") + key));
    }
  }
}

bool has_not_a_number(std::string_view text) {
  return text.find("NaN") != std::string_view::npos || text.find("nan") != std::string_view::npos ||
         text.find("Infinity") != std::string_view::npos || text.find("inf") != std::string_view::npos;
}

}  // namespace

std::array<std::byte, ServoPacket::kBytes> encode(const ServoPacket& packet) {
  std::array<std::byte, ServoPacket::kBytes> bytes{};
  std::size_t at = 0;
  put(ServoPacket::kMagic, bytes, at);
  put(packet.rate_hz, bytes, at);
  put(packet.frame, bytes, at);
  for (const std::uint16_t pulse : packet.pulse_us) {
    put(pulse, bytes, at);
  }
  return bytes;
}

PhysicsAnswer decode_answer(std::string_view datagram) {
  const std::string_view line = last_line(datagram);
  const Json in = Json::parse(line);
  if (!in.is_object()) {
    throw PhysicsError(has_not_a_number(line) ? "the answer holds a number that is not finite (NaN or infinity)"
                                              : "the answer is not a JSON object");
  }
  PhysicsAnswer out;
  out.time_s = number(field(in, "timestamp", "timestamp"), "timestamp");
  const Json& imu = field(in, "imu", "imu");
  if (!imu.is_object()) {
    throw PhysicsError("'imu' is not an object");
  }
  out.rate_b_rad_s = vector(imu, "gyro", "imu.gyro");
  out.specific_force_b_m_s2 = vector(imu, "accel_body", "imu.accel_body");
  out.position_w_m = vector(in, "position", "position");
  out.velocity_w_m_s = vector(in, "velocity", "velocity");
  out.rotation_wb = rotation(in);
  check_optional(in);
  return out;
}

}  // namespace m100::sim
