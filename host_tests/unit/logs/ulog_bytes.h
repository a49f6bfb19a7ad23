// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace m100::lab::logs {

/// Writes ULog from the published format, independently of the reader.
class UlogBytes {
 public:
  UlogBytes() : bytes_(std::string("ULog\x01\x12\x35\x01", 8) + std::string(8, '\0')) {}

  void message(char type, const std::string& payload) {
    bytes_ += raw(static_cast<std::uint16_t>(payload.size())) + type + payload;
  }
  void subscribe(std::uint8_t instance, std::uint16_t id, const std::string& name) {
    message('A', raw(instance) + raw(id) + name);
  }
  void data(std::uint16_t id, const std::string& payload) { message('D', raw(id) + payload); }
  void append(const std::string& bytes) { bytes_ += bytes; }

  template <typename T>
  static std::string raw(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace m100::lab::logs
