// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "firmware/core/frames.h"
#include "firmware/model/default_vehicle.h"

#ifdef M100_HAS_AES
#include "protocol/aes256.h"

// Checks the first byte of the encrypted block against FIPS 197, appendix C.3.
bool aes_is_right() {
  m100::protocol::CipherKey key{};
  std::array<std::byte, 16> block{};
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(i);
  }
  for (std::size_t i = 0; i < block.size(); ++i) {
    block[i] = static_cast<std::byte>(0x11 * i);
  }
  m100::protocol::Aes256(key).encrypt(block);
  return block[0] == std::byte{0x8E};
}
#else
bool aes_is_right() { return true; }
#endif

// Converts the attitude of a level vehicle that points west. Fails to link, or gives a wrong answer, if the package is
// incomplete.
int main() {
  const m100::core::Euler<double> west{.yaw_rad = m100::core::kPi / 2};
  const double yaw_rad = m100::core::euler_of(m100::core::quaternion_of(west)).yaw_rad;
  constexpr m100::model::Vehicle kPaper = m100::model::paper_vehicle();
  std::printf("yaw %.6f rad, roll %.3f rad/s\n", yaw_rad, kPaper.roll.natural_frequency_rad_s);
  return yaw_rad > 1.57 && yaw_rad < 1.571 && aes_is_right() ? 0 : 1;
}
