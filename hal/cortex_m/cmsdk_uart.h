// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/spsc_ring.h"
#include "hal/uart.h"

namespace m100::hal {

/// Registers of the Arm CMSDK APB UART: one byte deep each way, 8N1.
struct CmsdkUartRegisters {
  volatile std::uint32_t data;
  volatile std::uint32_t state;    ///< bit 0, 1: transmitter, receiver full; bit 2, 3: their overruns, write 1 to clear
  volatile std::uint32_t control;  ///< bit 0, 1: transmitter, receiver on; bit 2, 3: their interrupts on
  volatile std::uint32_t interrupt;  ///< bit 0, 1: transmit, receive interrupt; write 1 to clear
  volatile std::uint32_t divider;    ///< peripheral clock over baud rate, at least 16
};

/// A UART driven by its two interrupts: the receive handler pushes each byte into the receive ring, the transmit
/// handler pops each byte from the transmit ring. With interrupts on, the loop never touches the data register, so each
/// ring has one writer and one reader.
class CmsdkUart final : public Uart {
 public:
  static constexpr std::size_t kReceiveBytes = 512;  ///< 22 ms of 230400 baud: two periods of the loop
  static constexpr std::size_t kTransmitBytes = 256;

  /// @param pend the NVIC's "set pending" register of this UART's transmit interrupt.
  /// @param mask its bit there: writing it makes the machine run on_transmit() as if the transmitter had interrupted.
  CmsdkUart(CmsdkUartRegisters& registers, volatile std::uint32_t& pend, std::uint32_t mask)
      : registers_(registers), pend_(pend), mask_(mask) {}

  /// Switches both directions and their interrupts on. The caller enables them in the NVIC.
  void start(std::uint32_t clock_hz, std::uint32_t baud);

  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;

  /// Only overruns, of the data register and of the ring: this device detects neither a wrong stop bit nor a break.
  core::Expected<LineErrors> line_errors() const override;

  /// Sends the waiting bytes, then `source`, without interrupts (which must be off): for a release sequence. Gives up
  /// if the line accepts nothing for about a second.
  void write_without_interrupts(std::span<const std::byte> source);

  /// Interrupt handlers.
  void on_receive();
  void on_transmit();

  /// Bytes read from the data register since the start, also those that found the ring full; wraps.
  std::uint32_t received() const { return received_.load(std::memory_order_acquire); }
  /// Bytes that arrived while the ring was full; wraps.
  std::uint32_t lost() const { return incoming_.dropped(); }
  /// Bytes accepted by write() since the start; wraps.
  std::uint32_t accepted() const { return accepted_; }

 private:
  bool send_now(std::byte value);

  CmsdkUartRegisters& registers_;
  volatile std::uint32_t& pend_;
  std::uint32_t mask_;
  core::SpscRing<std::byte, kReceiveBytes> incoming_;
  core::SpscRing<std::byte, kTransmitBytes> outgoing_;
  std::atomic<std::uint32_t> received_{0};
  std::atomic<std::uint32_t> overruns_{0};
  std::uint32_t accepted_ = 0;
};

}  // namespace m100::hal
