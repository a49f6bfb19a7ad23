// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <string>

#include "firmware/core/time.h"
#include "hal/cortex_m/lockstep_message.h"
#include "hal/linux/descriptor.h"
#include "hal/uart.h"

namespace m100::sim {

/// A flight image in QEMU (mps2-an500) whose time is driven tick by tick: UART0 carries the steps of
/// hal/cortex_m/lockstep_message.h, UART1 the autopilot's link, UART2 the pose. The three are Unix sockets in a
/// temporary folder. The destructor ends the emulator.
class EmulatedBoard {
 public:
  /// Starts the emulator. @param arguments words for the image. @throws std::runtime_error if that fails.
  EmulatedBoard(const std::string& image, const std::string& arguments);
  ~EmulatedBoard();
  EmulatedBoard(const EmulatedBoard&) = delete;
  EmulatedBoard& operator=(const EmulatedBoard&) = delete;

  /// One tick: sends the waiting bytes of both ends to the board, and writes its bytes into them.
  /// @throws std::runtime_error if the board does not answer within a minute.
  hal::LockstepReport step(core::TimePoint now, hal::LockstepOrder order, hal::Uart& autopilot, hal::Uart& pose);

  /// Tells the image to end. @returns its exit status, -1 if it did not end by itself.
  int end();
  /// Makes an assertion fail in the image, or makes it hang; its last words go into the autopilot's line. @returns as
  /// end().
  int break_an_assertion(hal::Uart& autopilot) { return last_words(hal::LockstepOrder::kBreak, autopilot); }
  int hang(hal::Uart& autopilot) { return last_words(hal::LockstepOrder::kHang, autopilot); }

 private:
  static constexpr std::size_t kPorts = 3;
  void order_last(hal::LockstepOrder order);
  int wait_for_exit();
  int last_words(hal::LockstepOrder order, hal::Uart& autopilot);
  void start(const std::string& image, const std::string& arguments);
  void send(std::size_t port, const std::byte* data, std::size_t size);
  void receive(std::size_t port, std::byte* data, std::size_t size);
  std::uint32_t pass_on(hal::Uart& from, std::size_t port);
  void bring_back(std::size_t port, std::uint32_t& so_far, std::uint32_t total, hal::Uart& to);

  std::string folder_;
  pid_t emulator_ = -1;
  std::array<hal::Descriptor, kPorts> listening_;
  std::array<hal::Descriptor, kPorts> socket_;
  std::array<std::uint32_t, kPorts> sent_{};
  std::array<std::uint32_t, kPorts> received_{};
};

}  // namespace m100::sim
