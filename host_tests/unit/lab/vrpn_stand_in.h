// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace m100::lab::bridge {

/// Writes the stream of a VRPN server, from the description of its protocol: big endian, padded to 8 bytes.
struct VrpnStandIn {
  std::vector<std::byte> bytes;

  template <typename Value>
  void put(Value value) {
    auto turned = std::bit_cast<std::array<std::byte, sizeof(Value)>>(value);
    std::reverse(turned.begin(), turned.end());
    bytes.insert(bytes.end(), turned.begin(), turned.end());
  }
  void put32(std::int32_t value) { put(value); }
  void text(std::string_view words) {
    for (const char letter : words) {
      bytes.push_back(static_cast<std::byte>(letter));
    }
  }
  void cookie() {
    text("vrpn: ver. 07.35  0");
    bytes.resize(24);
  }
  void header(std::size_t body, double t_s, std::int32_t sender, std::int32_t type) {
    put32(static_cast<std::int32_t>(24 + body));
    put32(static_cast<std::int32_t>(t_s));
    put32(static_cast<std::int32_t>(std::lround(1e6 * (t_s - std::floor(t_s)))));
    put32(sender);
    put32(type);
    put32(number_++);
  }
  void fill() { bytes.resize((bytes.size() + 7) / 8 * 8); }
  /// @param type -1: names a sender; -2: names a message type.
  void name(std::int32_t type, std::int32_t id, std::string_view words) {
    header(4 + words.size() + 1, 0.0, id, type);
    put32(static_cast<std::int32_t>(words.size() + 1));
    text(words);
    bytes.push_back(std::byte{0});
    fill();
  }
  void pose(std::int32_t sender, std::int32_t type, std::int32_t sensor, double t_s,
            const std::array<double, 3>& position, const std::array<double, 4>& xyzw) {
    header(64, t_s, sender, type);
    put32(sensor);
    put32(0);
    for (const double value : position) {
      put(value);
    }
    for (const double value : xyzw) {
      put(value);
    }
  }

 private:
  std::int32_t number_ = 0;
};

}  // namespace m100::lab::bridge
