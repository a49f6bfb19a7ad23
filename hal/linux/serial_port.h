// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/core/time.h"
#include "hal/linux/simulated_port.h"
#include "hal/linux/system_calls.h"
#include "hal/uart.h"

namespace m100::hal {

/// A serial port of the operating system (also a pseudo-terminal): raw, 8N1, no flow control, non-blocking.
///
/// The port may be unplugged and come back, also as another device under the same name: read() and write() then report
/// kUnavailable and try to open the name again, at most every kReopenInterval. Input that was waiting in the driver
/// when the port is opened is discarded, because it may be old. Allocates in the constructor only.
/// A name that begins with "sim:" is a simulated port (simulated_port.h).
class SerialPort final : public Uart {
 public:
  static constexpr core::Duration kReopenInterval = std::chrono::milliseconds(200);

  /// Does not open the port. The first read() or write() does; call open() if the reason of a failure matters.
  /// @param baud 115200, 230400, 460800 or 921600; others are refused by open().
  SerialPort(std::string path, std::uint32_t baud, const SystemCalls& calls = real_system_calls());
  ~SerialPort();

  /// @returns kOk; kInvalidArgument: the baud rate is not supported; kRefused: no right to open it, or another program
  ///   holds it; kUnavailable: no such device, or it is not a serial port.
  core::Status open();
  void close();
  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }  ///< -1: closed

  /// Until this is called again, read() gives only bytes that have arrived by now. Call it before the time of a tick
  /// is taken: bytes that arrive later, while the program is interrupted, are left to the next tick, and never get
  /// a time before they were sent. A simulated port does not need it.
  void mark_arrived();
  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;

  /// The driver's counts since the port was first opened, without those of a device that was unplugged.
  /// kUnavailable also where the driver counts nothing: a pseudo-terminal, some USB adapters.
  core::Expected<LineErrors> line_errors() const override;

  /// How often the port was opened successfully: more than 1 means that it was missing in between.
  std::uint32_t openings() const { return openings_; }
  const std::string& path() const { return path_; }

 private:
  bool ensure_open();
  bool configure();
  /// How many bytes a read() gets without waiting. kUnavailable: the port was unplugged.
  core::Expected<std::size_t> waiting_bytes(std::size_t most) const;
  core::Expected<LineErrors> driver_counts() const;

  std::string path_;
  std::uint32_t baud_;
  const SystemCalls* calls_;
  int descriptor_ = -1;
  std::uint32_t openings_ = 0;
  bool unreported_loss_ = false;        ///< write() found the port missing, and read() has not reported it yet
  std::optional<std::size_t> arrived_;  ///< marked and not yet read; empty: not marked
  LineErrors before_;                   ///< of earlier openings
  LineErrors at_opening_;               ///< the driver's counts when the port was opened
  PortClock clock_;
  core::TimePoint next_attempt_{};
};

}  // namespace m100::hal
