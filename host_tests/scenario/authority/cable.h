// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/time.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"
#include "host_tests/sim/ports/lockstep_host.h"
#include "host_tests/sim/ports/pty_uart.h"

namespace m100::authority {

/// The four line ends at the man in the middle.
enum class End : std::size_t { kClient, kClientPose, kAutopilot, kAutopilotPose };
inline constexpr std::size_t kEnds = 4;

/// Two lines, each cut in the middle, and the time of the programs at their ends.
class Cable {
 public:
  Cable() = default;
  virtual ~Cable() = default;
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;

  /// The name that a program gives as its port.
  virtual std::string port_of(End end) const = 0;
  virtual std::vector<std::byte> take(End end) = 0;
  virtual void give(End end, std::span<const std::byte> bytes) = 0;
  virtual void unplug(End end) = 0;
  virtual void plug_in(End end) = 0;
  virtual core::TimePoint now() = 0;
  /// Advances time by a step.
  virtual void advance() = 0;
  /// Waits until the process takes part; simulated time stands still meanwhile. @returns false if it did not.
  virtual bool wait_for(pid_t process) = 0;
  /// Gives the process no time until it is resumed. The caller sends the signals.
  virtual void suspend(pid_t process) = 0;
  virtual void resume(pid_t process) = 0;
  /// Whether the process takes part in simulated time. Afterwards its work takes only the machine's time.
  virtual bool takes_part(pid_t process) = 0;
};

/// Simulated ports: time runs as fast as the programs can.
class SimulatedCable final : public Cable {
 public:
  explicit SimulatedCable(const std::string& folder);
  std::string port_of(End end) const override;
  std::vector<std::byte> take(End end) override { return host_.take(number(end)); }
  void give(End end, std::span<const std::byte> bytes) override { host_.give(number(end), bytes); }
  void unplug(End end) override { host_.unplug(number(end)); }
  void plug_in(End end) override { host_.plug_in(number(end)); }
  core::TimePoint now() override { return host_.now(); }
  void advance() override { host_.advance(host_.now() + std::chrono::milliseconds(5)); }
  bool wait_for(pid_t process) override;
  void suspend(pid_t process) override { host_.suspend(process); }
  void resume(pid_t process) override { host_.resume(process); }
  bool takes_part(pid_t process) override { return host_.is_attached(process); }

 private:
  static std::size_t number(End end) { return static_cast<std::size_t>(end); }
  std::string folder_;
  sim::LockstepHost host_;
};

/// Pseudo-terminals in real time: one for each program's end of each line.
class RealCable final : public Cable {
 public:
  RealCable(const std::string& folder, std::uint32_t baud);
  std::string port_of(End end) const override;
  std::vector<std::byte> take(End end) override;
  void give(End end, std::span<const std::byte> bytes) override;
  void unplug(End end) override;
  void plug_in(End end) override;
  core::TimePoint now() override { return clock_.now(); }
  void advance() override { clock_.sleep_until(clock_.now() + std::chrono::milliseconds(1)); }
  bool wait_for(pid_t process) override;
  void suspend(pid_t) override {}
  void resume(pid_t) override {}
  bool takes_part(pid_t) override { return true; }

 private:
  hal::Uart* uart(End end);

  std::string folder_;
  hal::MonotonicClock clock_;
  std::array<std::optional<sim::PtyUart>, 2> clients_;        ///< created here, opened by m100
  std::array<std::optional<hal::SerialPort>, 2> autopilots_;  ///< created by m100-lab, opened here
};

}  // namespace m100::authority
