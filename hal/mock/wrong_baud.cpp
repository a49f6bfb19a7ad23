// SPDX-License-Identifier: BSD-3-Clause
#include "hal/mock/wrong_baud.h"

#include <cstddef>

namespace m100::hal {
namespace {

constexpr std::size_t kBitsPerByte = 10;

/// The level of the line during one of the sender's bit times; idle is high.
bool level(std::span<const std::byte> sent, std::size_t sender_bit) {
  const std::size_t index = sender_bit / kBitsPerByte;
  const std::size_t bit = sender_bit % kBitsPerByte;
  if (index >= sent.size() || bit == kBitsPerByte - 1) {
    return true;
  }
  return bit != 0 && (std::to_integer<unsigned>(sent[index]) >> (bit - 1) & 1U) != 0;
}

}  // namespace

std::vector<std::byte> received_at(std::span<const std::byte> sent, std::uint32_t sender_baud,
                                   std::uint32_t receiver_baud, bool keep_framing_errors) {
  std::vector<std::byte> received;
  const double bits_per_sample = static_cast<double>(sender_baud) / receiver_baud;  // sender's bits per receiver's bit
  const auto end = static_cast<double>(sent.size() * kBitsPerByte);
  const auto sample = [&](double at) { return level(sent, static_cast<std::size_t>(at)); };
  constexpr double kEdgeSearch = 1.0 / 16.0;  // a UART samples for the edge sixteen times per bit
  double at = 0.0;
  while (at < end) {
    if (sample(at)) {
      at += kEdgeSearch * bits_per_sample;
      continue;
    }
    unsigned value = 0;
    for (std::size_t bit = 0; bit < 8; ++bit) {
      const bool high = sample(at + (1.5 + static_cast<double>(bit)) * bits_per_sample);
      value |= static_cast<unsigned>(high) << bit;
    }
    const bool stop_is_high = sample(at + 9.5 * bits_per_sample);
    if (stop_is_high || keep_framing_errors) {
      received.push_back(static_cast<std::byte>(value));
    }
    at += 9.5 * bits_per_sample;
    while (at < end && !sample(at)) {
      at += kEdgeSearch * bits_per_sample;  // a line that is still low must rise before the next start bit
    }
  }
  return received;
}

}  // namespace m100::hal
