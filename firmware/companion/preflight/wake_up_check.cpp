// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/wake_up_check.h"

#include <fcntl.h>
#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "hal/linux/descriptor.h"
#include "hal/linux/monotonic_clock.h"
#include "hal/linux/serial_port.h"

namespace m100::companion::preflight {
namespace {

constexpr int kPriority = 50;  ///< of SCHED_FIFO, as in a flight

/// Threads of normal priority that keep processors and disk busy while it lives.
class Load {
 public:
  explicit Load(const std::string& folder) : file_(folder + "/m100-doctor-XXXXXX"), descriptor_(mkstemp(file_.data())) {
    const unsigned loops = std::max(2U, std::thread::hardware_concurrency());
    for (unsigned i = 0; i < loops; ++i) {
      threads_.emplace_back([](const std::stop_token& ends) {
        while (!ends.stop_requested()) {
        }
      });
    }
    if (descriptor_.number >= 0) {
      (void)unlink(file_.c_str());
      threads_.emplace_back([this](const std::stop_token& ends) { write_to_disk(ends); });
    }
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  void write_to_disk(const std::stop_token& ends) const {
    const std::vector<char> block(std::size_t{1} << 20U, 'x');
    while (!ends.stop_requested()) {
      (void)!pwrite(descriptor_.number, block.data(), block.size(), 0);
      (void)fsync(descriptor_.number);
    }
  }

  std::string file_;
  hal::Descriptor descriptor_;
  std::vector<std::jthread> threads_;  ///< last: they end first
};

/// A pseudo-terminal to read from, with a package of telemetry in each tick.
class Line {
 public:
  Line() : far_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    if (far_.number >= 0 && grantpt(far_.number) == 0 && unlockpt(far_.number) == 0) {
      port_.emplace(ptsname(far_.number), 230400);
    }
  }

  void tick() {
    std::array<std::byte, 256> bytes{};
    if (port_) {
      (void)port_->read(bytes);
      (void)!::write(far_.number, bytes.data(), kPackageBytes);
    }
  }

 private:
  static constexpr std::size_t kPackageBytes = 142;
  hal::Descriptor far_;
  std::optional<hal::SerialPort> port_;
};

}  // namespace

WakeUps measure_wake_ups(const std::string& folder, core::Duration duration) {
  Line line;
  const Load load(folder);  // before this thread's priority, which its threads would inherit
  const sched_param priority{.sched_priority = kPriority};
  const sched_param normal{.sched_priority = 0};
  WakeUps measured{.real_time = sched_setscheduler(0, SCHED_FIFO, &priority) == 0};
  hal::MonotonicClock clock;
  const core::TimePoint end = clock.now() + duration;
  for (core::TimePoint deadline = clock.now(); deadline < end;) {
    deadline += core::kTickPeriod;
    clock.sleep_until(deadline);
    line.tick();
    const core::Duration lateness = clock.now() - deadline;
    measured.worst = std::max(measured.worst, lateness);
    measured.late += lateness > kLate ? 1U : 0U;
    ++measured.ticks;
  }
  if (measured.real_time) {
    (void)sched_setscheduler(0, SCHED_OTHER, &normal);
  }
  return measured;
}

CheckResult judge_wake_ups(const WakeUps& measured) {
  std::array<char, 200> finding{};
  std::snprintf(
      finding.data(), finding.size(),
      "with every processor and the disk busy, %u ticks of 10 ms were up to %.1f ms late, %u of them more than "
      "20 ms%s",
      measured.ticks, 1e3 * core::seconds<double>(measured.worst), measured.late,
      measured.real_time ? "" : " (without real-time rights)");
  const Health health = measured.worst > kTooLate ? Health::kBad
                        : measured.late > 0       ? Health::kDoubtful
                                                  : Health::kGood;
  return {"wake-up under load", health, finding.data(),
          health == Health::kGood
              ? ""
              : "grant real-time rights; keep a processor for the flight (isolcpus=N on the kernel's "
                "command line, CPUAffinity=N in the unit); a kernel with PREEMPT_RT"};
}

}  // namespace m100::companion::preflight
