// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/cable.h"

#include <signal.h>
#include <sys/wait.h>

#include <filesystem>

namespace m100::authority {
namespace {

constexpr double kPatience_s = 300.0;  // real time for a program to start on a busy machine
constexpr std::array kNames{"port", "pose", "n1", "n1_pose"};
constexpr std::uint32_t kPoseBaud = 115200;

const char* name_of(End end) { return kNames[static_cast<std::size_t>(end)]; }

}  // namespace

SimulatedCable::SimulatedCable(const std::string& folder) : folder_(folder) {
  for (const char* const name : kNames) {
    (void)host_.add_end(folder_ + "/" + name);
  }
}

std::string SimulatedCable::port_of(End end) const { return "sim:" + folder_ + "/" + name_of(end); }

bool SimulatedCable::wait_for(pid_t process) {
  const auto has_ended = [process] {
    siginfo_t ending{};
    return ::waitid(P_PID, static_cast<id_t>(process), &ending, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ending.si_pid == process;
  };
  return host_.wait_for([&] { return host_.is_attached(process) || has_ended(); }, kPatience_s) && !has_ended();
}

RealCable::RealCable(const std::string& folder, std::uint32_t baud) : folder_(folder) {
  clients_[0].emplace(port_of(End::kClient));
  clients_[1].emplace(port_of(End::kClientPose));
  autopilots_[0].emplace(port_of(End::kAutopilot), baud);
  autopilots_[1].emplace(port_of(End::kAutopilotPose), kPoseBaud);
}

std::string RealCable::port_of(End end) const { return folder_ + "/" + name_of(end); }

hal::Uart* RealCable::uart(End end) {
  const std::size_t line = static_cast<std::size_t>(end) % 2;
  if (end == End::kClient || end == End::kClientPose) {
    return clients_[line] ? &*clients_[line] : nullptr;
  }
  return &*autopilots_[line];
}

std::vector<std::byte> RealCable::take(End end) {
  std::vector<std::byte> bytes(4096);
  hal::Uart* const from = uart(end);
  bytes.resize(from != nullptr ? from->read(bytes).value_or(0) : 0);
  return bytes;
}

void RealCable::give(End end, std::span<const std::byte> bytes) {
  if (hal::Uart* const to = uart(end); to != nullptr && !bytes.empty()) {
    (void)to->write(bytes);
  }
}

void RealCable::unplug(End end) { clients_[static_cast<std::size_t>(end) % 2].reset(); }

void RealCable::plug_in(End end) { clients_[static_cast<std::size_t>(end) % 2].emplace(port_of(end)); }

bool RealCable::wait_for(pid_t process) {
  // Waits for the autopilot's links. The client needs no wait, because it reports itself that it has started.
  (void)process;
  for (double waited_s = 0.0; waited_s < kPatience_s; waited_s += 0.01) {
    if (std::filesystem::exists(port_of(End::kAutopilot)) && std::filesystem::exists(port_of(End::kAutopilotPose))) {
      return true;
    }
    clock_.sleep_until(clock_.now() + std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace m100::authority
