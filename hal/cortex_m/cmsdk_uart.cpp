// SPDX-License-Identifier: BSD-3-Clause
#include "hal/cortex_m/cmsdk_uart.h"

namespace m100::hal {
namespace {

constexpr std::uint32_t kTransmitterFull = 1U << 0U;
constexpr std::uint32_t kReceiverFull = 1U << 1U;
constexpr std::uint32_t kReceiverOverran = 1U << 3U;
constexpr std::uint32_t kAllOn = 0xFU;
constexpr std::uint32_t kTransmitInterrupt = 1U << 0U;
constexpr std::uint32_t kReceiveInterrupt = 1U << 1U;
constexpr std::uint32_t kSmallestDivider = 16;

}  // namespace

void CmsdkUart::start(std::uint32_t clock_hz, std::uint32_t baud) {
  const std::uint32_t divider = clock_hz / baud;
  registers_.divider = divider < kSmallestDivider ? kSmallestDivider : divider;
  registers_.control = kAllOn;
}

core::Expected<std::size_t> CmsdkUart::read(std::span<std::byte> destination) {
  return incoming_.pop_into(destination).size();
}

core::Expected<std::size_t> CmsdkUart::write(std::span<const std::byte> source) {
  std::size_t taken = 0;
  while (taken < source.size() && outgoing_.size() < outgoing_.capacity()) {
    outgoing_.push(source[taken]);
    ++taken;
  }
  accepted_ += static_cast<std::uint32_t>(taken);
  if (taken > 0) {
    pend_ = mask_;
  }
  return taken;
}

core::Expected<LineErrors> CmsdkUart::line_errors() const {
  return LineErrors{
      .framing = 0, .parity = 0, .overrun = overruns_.load(std::memory_order_acquire) + lost(), .breaks = 0};
}

bool CmsdkUart::send_now(std::byte value) {
  constexpr std::uint32_t kPatience = 5000000;
  for (std::uint32_t visit = 0; visit < kPatience; ++visit) {
    if ((registers_.state & kTransmitterFull) == 0U) {
      registers_.data = std::to_integer<std::uint32_t>(value);
      return true;
    }
  }
  return false;
}

void CmsdkUart::write_without_interrupts(std::span<const std::byte> source) {
  bool alive = true;
  for (std::byte waiting{}; alive && outgoing_.pop(waiting);) {
    alive = send_now(waiting);
  }
  for (std::size_t i = 0; alive && i < source.size(); ++i) {
    alive = send_now(source[i]);
  }
}

void CmsdkUart::on_receive() {
  registers_.interrupt = kReceiveInterrupt;  // before the read: a byte that follows at once interrupts again
  const std::uint32_t state = registers_.state;
  if ((state & kReceiverOverran) != 0U) {
    registers_.state = kReceiverOverran;
    overruns_.store(overruns_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
  if ((state & kReceiverFull) != 0U) {
    incoming_.push(static_cast<std::byte>(registers_.data & 0xFFU));
    received_.store(received_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
}

void CmsdkUart::on_transmit() {
  registers_.interrupt = kTransmitInterrupt;
  std::byte next{};
  if ((registers_.state & kTransmitterFull) == 0U && outgoing_.pop(next)) {
    registers_.data = std::to_integer<std::uint32_t>(next);
  }
}

}  // namespace m100::hal
