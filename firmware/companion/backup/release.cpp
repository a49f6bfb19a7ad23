// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/backup/release.h"

#include <unistd.h>

#include <chrono>
#include <iostream>
#include <thread>

#include "firmware/companion/backup/backup_process.h"
#include "firmware/link/release_sequence.h"
#include "hal/linux/system_calls.h"

namespace m100::companion {
namespace {

/// The second process sends after kHeartbeatTimeout without a heartbeat and needs its rounds; one period more for a
/// loaded board.
constexpr core::Duration kBackupDone =
    BackupProcess::kHeartbeatTimeout + (static_cast<int>(BackupProcess::kRounds) + 1) * BackupProcess::kRoundInterval;
constexpr core::Duration kRetryInterval = std::chrono::milliseconds(100);

core::Status open_with_retries(hal::SerialPort& port) {
  core::Status status = port.open();
  for (core::Duration waited{0}; status == core::Status::kRefused && waited < kBackupDone; waited += kRetryInterval) {
    std::this_thread::sleep_for(kRetryInterval);
    status = port.open();
  }
  return status;
}

}  // namespace

bool release_only(const FlyOptions& options, const link::LinkConfig& config) {
  hal::SerialPort port(options.port, options.baud);
  const core::Status status = open_with_retries(port);
  // A port that another process still holds keeps that process's baud rate.
  const int descriptor = status == core::Status::kRefused ? hal::open_device(options.port.c_str()) : port.descriptor();
  const protocol::Cipher* const cipher = config.encrypt_commands ? config.cipher : nullptr;
  // From the clock: the autopilot may remember the numbers of an earlier flight, and executes none of them again.
  const auto first = static_cast<std::size_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  bool sent = descriptor >= 0;
  for (std::size_t round = 0; sent && round < BackupProcess::kRounds; ++round) {
    const link::ReleaseSequence words(ctl::Command<double>{}, cipher, static_cast<std::uint16_t>(first + round));
    const std::span<const std::byte> bytes = words.release_only();
    sent = ::write(descriptor, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
    std::this_thread::sleep_for(BackupProcess::kRoundInterval);
  }
  std::cout << options.port << (sent ? ": the release of control was sent" : ": the release of control cannot be sent")
            << std::endl;
  return sent;
}

}  // namespace m100::companion
