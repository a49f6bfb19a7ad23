// SPDX-License-Identifier: BSD-3-Clause
// The flight program on QEMU's mps2-an500: autopilot on UART1, pose and the operator's switch on UART2, time from
// SysTick, and a watchdog. With "lockstep" on the emulator's command line, time and further orders come from a
// simulation on UART0 (hal/cortex_m/lockstep_*.h). Control is taken on an order only.
#include <cstdint>

#include "firmware/app/flight_controller.h"
#include "firmware/app/image/board_course.h"
#include "firmware/app/image/order_tap.h"
#include "firmware/app/image/tick_schedule.h"
#include "firmware/core/assert.h"
#include "firmware/link/release_sequence.h"
#include "firmware/mpc/generated/gain_table.h"
#include "firmware/ref/trajectory.h"
#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/cmsdk_watchdog.h"
#include "hal/cortex_m/exceptions.h"
#include "hal/cortex_m/lockstep_clock.h"
#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/stack_paint.h"
#include "hal/cortex_m/systick_clock.h"

namespace {

using namespace m100;
using Controller = app::FlightController<float>;
using Course = ref::Trajectory<float>;

constexpr mpc::GainTables<float> kTables{mpc::generated::kX<float>, mpc::generated::kY<float>};
constexpr std::uint32_t kBaud = 230400;
constexpr std::uint32_t kClockPeriod_us = 10000;
/// If the program hangs, its release sequence leaves after this time, and if that hangs, too, the board resets after
/// twice this time (R15: 1.5 s).
constexpr core::Duration kPatience = std::chrono::milliseconds(500);

hal::CmsdkUart autopilot_uart(hal::mps2::uart(1), hal::mps2::set_pending(), hal::mps2::transmit_mask(1));
hal::CmsdkUart pose_uart(hal::mps2::uart(2), hal::mps2::set_pending(), hal::mps2::transmit_mask(2));
[[gnu::section(".harness.control")]] hal::CmsdkUart control_uart(hal::mps2::uart(0), hal::mps2::set_pending(),
                                                                 hal::mps2::transmit_mask(0));
app::OrderTap<hal::CmsdkUart> pose_line(pose_uart);
hal::CmsdkWatchdog watchdog(hal::mps2::watchdog(), hal::mps2::watchdog_lock(), hal::mps2::kClock_hz);
hal::SysTickClock system_clock(hal::mps2::systick(), hal::mps2::kClock_hz, kClockPeriod_us);
Course course;

const link::ReleaseSequence* last_words = nullptr;

/// Sends neutral sticks and the release of control, whatever the rest of the program is doing.
void say_last_words() {
  asm volatile("cpsid i");
  if (last_words != nullptr) {
    autopilot_uart.write_without_interrupts(last_words->bytes());
  }
}

/// The handler of a failed assertion.
[[noreturn]] void send_release_sequence(const char* file, int line) {
  say_last_words();
  hal::fail_assertion(file, line);
}

/// Passes the operator's order to the controller.
void obey(app::Order order, Controller& controller) {
  if (order == app::Order::kEngage) {
    controller.engage();
  } else if (order == app::Order::kRelease) {
    controller.release();
  }
}

/// One tick for each step of the simulation, until the simulation ends the flight.
void fly_in_lockstep(Controller& controller) {
  hal::LockstepClock clock(control_uart, autopilot_uart, pose_uart);
  for (;;) {
    clock.sleep_until(clock.now());
    switch (clock.order()) {
      case hal::LockstepOrder::kEngage:
        obey(app::Order::kEngage, controller);
        break;
      case hal::LockstepOrder::kRelease:
        obey(app::Order::kRelease, controller);
        break;
      case hal::LockstepOrder::kEnd:
        return;
      case hal::LockstepOrder::kBreak:
        M100_ASSERT(clock.order() != hal::LockstepOrder::kBreak);
        break;
      case hal::LockstepOrder::kHang:
        watchdog.start(kPatience);
        for (;;) {
          asm volatile("");
        }
      case hal::LockstepOrder::kNone:
        break;
    }
    obey(pose_line.take(), controller);
    const std::uint64_t before = system_clock.cycles();
    static_cast<void>(controller.tick(clock.now()));  // the result of the command is in the supervisor's state
    clock.report(static_cast<std::uint32_t>(system_clock.cycles() - before), hal::deepest_stack_bytes());
  }
}

/// Ticks for ever, by the board's own clock. The watchdog is fed at the end of a tick and nowhere else.
[[noreturn]] void fly_by_own_clock(Controller& controller) {
  watchdog.start(kPatience);
  core::TimePoint next = system_clock.now();
  for (;;) {
    system_clock.sleep_until(next);
    obey(pose_line.take(), controller);
    const core::TimePoint now = system_clock.now();
    static_cast<void>(controller.tick(now));
    watchdog.feed();
    next = app::tick_after(next, now);
  }
}

}  // namespace

extern "C" {
/// The watchdog's interrupt: the program hangs. The watchdog keeps counting, and resets the board if this hangs, too.
void NMI_Handler() {
  say_last_words();
  hal::print("watchdog: the program hung\n");
  hal::exit_emulator(hal::kExitOfWatchdog);
}
void SysTick_Handler() { system_clock.on_period(); }
void Uart0Rx_Handler() { control_uart.on_receive(); }
void Uart0Tx_Handler() { control_uart.on_transmit(); }
void Uart1Rx_Handler() { autopilot_uart.on_receive(); }
void Uart1Tx_Handler() { autopilot_uart.on_transmit(); }
void Uart2Rx_Handler() { pose_uart.on_receive(); }
void Uart2Tx_Handler() { pose_uart.on_transmit(); }
}

int main() {
  core::set_assertion_handler(&send_release_sequence);
  const bool lockstep = hal::argument(1) == "lockstep";
  if (app::append_board_course(lockstep ? hal::argument(2) : "hover", course) != core::Status::kOk) {
    hal::print("unknown course; choose hover, step, trajectory\n");
    return 2;
  }
  app::FlightConfig config = app::kDefaultFlight;
  config.link.app_id = 1;
  config.fence = app::kBoardFence;
  config.reach_m = app::kBoardReach_m;
  config.solves_when_due = true;
  static Controller controller(mpc::generated::kVehicle, kTables, config, autopilot_uart, pose_line, course, nullptr);
  static const link::ReleaseSequence release_sequence(vrc::CommandMap(mpc::generated::kVehicle).neutral(), nullptr);
  last_words = &release_sequence;
  control_uart.start(hal::mps2::kClock_hz, kBaud);
  autopilot_uart.start(hal::mps2::kClock_hz, kBaud);
  pose_uart.start(hal::mps2::kClock_hz, config.pose_baud);
  hal::mps2::enable_uart_interrupts();
  system_clock.start();
  if (!lockstep) {
    fly_by_own_clock(controller);
  }
  fly_in_lockstep(controller);
  return 0;
}
