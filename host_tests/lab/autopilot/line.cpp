// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/autopilot/line.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "hal/linux/serial_port.h"
#include "host_tests/lab/autopilot/event_file.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/sim/body/step_response.h"
#include "host_tests/sim/ports/lockstep_host.h"
#include "host_tests/sim/ports/pose_sender.h"
#include "host_tests/sim/ports/pty_uart.h"
#include "host_tests/sim/world/vehicle.h"

namespace m100::lab::autopilot {
namespace {

constexpr std::uint32_t kPoseBaud = 115200;

/// Our end of a line: a pseudo-terminal that we create, or a simulated port, whose host keeps the time.
std::shared_ptr<hal::Uart> serial_end(const std::string& name, std::uint32_t baud) {
  if (hal::is_simulated(name)) {
    return std::make_shared<hal::SerialPort>(name, baud == 0 ? kPoseBaud : baud);
  }
  return std::make_shared<sim::PtyUart>(name, baud);
}

/// Our own simulated ports: programs that open SOCKET and SOCKET.pose share our time, which starts with the first one
/// and, without --duration, stands still kRunOn after the last one has left.
class LockstepWorld {
 public:
  LockstepWorld(const std::string& socket, bool has_end)
      : has_end_(has_end),
        pose_client_(host_.add_end(socket + ".pose")),
        ours_(host_.add_end(socket + ".n1")),
        our_pose_(host_.add_end(socket + ".n1.pose")),
        client_(host_.add_end(socket)),
        clock_thread_([this] { run_clock(); }) {}
  ~LockstepWorld() {
    host_.stop();
    clock_thread_.join();
  }
  LockstepWorld(const LockstepWorld&) = delete;
  LockstepWorld& operator=(const LockstepWorld&) = delete;

 private:
  void forward_bytes(sim::LockstepHost::End from, sim::LockstepHost::End to) { host_.give(to, host_.take(from)); }
  void run_clock() {
    constexpr double kLong_s = 86400.0;
    constexpr core::Duration kRunOn = std::chrono::seconds(10);
    // A client or a signal to end starts the time. Without time the autopilot would not wake up and see the signal.
    const auto has_work = [this] { return host_.attached_count() >= 2 || stop_requested(); };
    core::TimePoint stop{};
    while (!host_.stopped()) {
      if (!has_work() && host_.now() >= stop) {
        host_.wait_for(has_work, kLong_s);
      }
      if (has_work()) {
        stop = has_end_ ? core::TimePoint::max() : host_.now() + kRunOn;
      }
      host_.advance(host_.now() + std::chrono::seconds(1));
      forward_bytes(client_, ours_);
      forward_bytes(ours_, client_);
      forward_bytes(our_pose_, pose_client_);
      forward_bytes(pose_client_, our_pose_);
    }
  }

  const bool has_end_;  ///< --duration ends the run, whether or not a client is there
  sim::LockstepHost host_;
  sim::LockstepHost::End pose_client_;
  sim::LockstepHost::End ours_;
  sim::LockstepHost::End our_pose_;
  sim::LockstepHost::End client_;  ///< created last: when its name exists, the others exist too
  std::thread clock_thread_;
};

/// Script lines that are typed in during the run: each takes effect at once, whatever time it names.
class LiveScript {
 public:
  void step(sim::N1Autopilot& autopilot) {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    std::array<char, 256> typed;
    while (open_ && ::poll(&input, 1, 0) > 0) {
      const ssize_t count = ::read(STDIN_FILENO, typed.data(), typed.size());
      open_ = count > 0;
      text_.append(typed.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    }
    for (std::size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1)) {
      execute(text_.substr(0, end), autopilot);
    }
  }

 private:
  static void execute(const std::string& typed, sim::N1Autopilot& autopilot) {
    try {
      for (const sim::N1ScriptLine& line : sim::read_n1_script(typed)) {
        autopilot.happen(line);
      }
    } catch (const sim::N1ScriptError& wrong) {
      throw InputError("standard input", 0, "", wrong.what());
    }
  }

  bool open_ = true;
  std::string text_;
};

/// Sends the poses that are due by now, with the pose faults of the script.
void send(sim::PoseSender& pose, core::TimePoint now, sim::N1Autopilot& autopilot, const sim::VehiclePort& vehicle) {
  pose.source().set_faults({.silent = !autopilot.pose_on(), .fault = [&autopilot](sim::PoseSample& sample) {
                              if (autopilot.fault_injector() != nullptr) {
                                autopilot.fault_injector()->apply(sample);
                              }
                            }});
  pose.step(now, vehicle, autopilot.ticked_at());
}

/// The aircraft: the identified response, or a physics program's body, which stands still once the program has failed.
class Aircraft final : public sim::VehiclePort {
 public:
  Aircraft(const Options& options, const sim::Plant& plant)
      : job_(options.body), identified_(plant, options.seed, place(options)) {
    identified_.set_motors(!options.on_ground);
    if (!options.body.is_identified()) {
      body_ =
          options.on_ground ? job_.body(plant, options.seed) : job_.flying_body(plant, options.seed, place(options));
      if (!options.on_ground) {
        std::cout << sim::compare_response(*body_, place(options)) << "; learned hover thrust " << body_->hover_thrust()
                  << " of full" << std::endl;
      }
      body_->start_time();
    }
  }
  void command(const sim::VehicleInput& input) override { flown().command(input); }
  void set_motors(bool on) override { flown().set_motors(on); }
  void advance(core::Duration step) override {
    if (!stands_still_) {
      flown().advance(step);
    }
  }
  const sim::VehicleState& state() const override { return flown().state(); }
  const sim::VehicleState& estimated() const override { return flown().estimated(); }
  core::Euler<double> attitude() const override { return flown().attitude(); }
  void stand_still() { stands_still_ = true; }

 private:
  static core::Vector<double, 3> place(const Options& options) { return {0.0, 0.0, options.on_ground ? 0.0 : 1.5}; }
  sim::VehiclePort& flown() { return body_ ? static_cast<sim::VehiclePort&>(*body_) : identified_; }
  const sim::VehiclePort& flown() const {
    return body_ ? static_cast<const sim::VehiclePort&>(*body_) : static_cast<const sim::VehiclePort&>(identified_);
  }

  sim::BodyJob job_;
  sim::Vehicle identified_;
  std::unique_ptr<sim::Body> body_;
  bool stands_still_ = false;
};

/// The time of the autopilot's next tick, or of the next event of the sender of poses if that is earlier.
core::TimePoint next_event(core::TimePoint now, const sim::PoseSender* pose) {
  const core::TimePoint tick = now + sim::N1Autopilot::kTick;
  return pose != nullptr && pose->next_event() > now ? std::min(tick, pose->next_event()) : tick;
}

/// Runs until the duration is over or a signal arrives. If the physics program fails, the pilot takes control, the
/// client has a second to see it, and the error is rethrown.
void fly(const Options& options, hal::PortClock& clock, sim::N1Autopilot& autopilot, Aircraft& vehicle,
         sim::PoseSender* pose, EventFile* events) {
  constexpr core::Duration kHandOver = std::chrono::seconds(1);
  std::optional<core::TimePoint> failed_end;
  std::exception_ptr failed;
  const core::TimePoint end{core::Duration{static_cast<std::int64_t>(options.duration_s * 1e6)}};
  core::TimePoint last = clock.now();
  core::Duration longest_lag{0};
  LiveScript live;
  for (core::TimePoint now = last;
       !stop_requested() && (options.duration_s <= 0.0 || now < end) && (!failed_end || now < *failed_end);
       now = clock.now()) {
    longest_lag = std::max(longest_lag, now - last);
    last = now;
    if (options.script == kLiveScript) {
      live.step(autopilot);
    }
    try {
      autopilot.advance(now);
    } catch (const sim::PhysicsError&) {
      failed = std::current_exception();
      failed_end = clock.now() + kHandOver;
      vehicle.stand_still();
      autopilot.happen(sim::N1EventKind::kTake, 'r');
    }
    if (pose != nullptr && !failed) {
      send(*pose, now, autopilot, vehicle);
    }
    if (events != nullptr) {
      events->write_truth(now, vehicle.state());
    }
    clock.sleep_until(next_event(now, pose));
  }
  if (events != nullptr) {
    events->summarise(clock.now(), autopilot, longest_lag);
  }
  if (failed) {
    std::rethrow_exception(failed);
  }
}

}  // namespace

void run_on_line(const Options& options, const sim::Plant& plant, const sim::N1Config& config) {
  std::signal(SIGPIPE, SIG_IGN);     // a client may disconnect
  Aircraft vehicle(options, plant);  // first, because a body's take-off takes time, and may fail
  const bool own_world = !options.simulated.empty();
  std::optional<LockstepWorld> world;
  if (own_world) {
    world.emplace(options.simulated, options.duration_s > 0.0);
  }
  const std::string name = own_world ? "sim:" + options.simulated + ".n1" : options.pty;
  const std::string pose_name = own_world ? "sim:" + options.simulated + ".n1.pose" : options.pose_pty;
  const std::shared_ptr<hal::Uart> line = serial_end(name, options.baud);
  std::optional<EventFile> events;  // after the line: if the line fails, the events of an earlier run are kept
  if (!options.events.empty()) {
    const bool is_simulated = hal::is_simulated(name);  // also if another program keeps the time
    events.emplace(options.events, is_simulated ? EventFile::WriteMode::kAtOnce : EventFile::WriteMode::kInAThread);
  }
  sim::N1Autopilot autopilot(*line, vehicle, config);
  autopilot.happen(sim::N1EventKind::kLoss, options.loss);
  if (events) {
    autopilot.on_event([&](const sim::N1Event& event) { events->write(event); });
  }
  // The pilot's sticks rest at the trims of the aircraft.
  autopilot.set_pilot_sticks({.roll_vrc = 1024.0 + plant.roll.trim_counts,
                              .pitch_vrc = 1024.0 + plant.pitch.trim_counts,
                              .throttle_vrc = 1024.0 + plant.climb.trim_counts,
                              .yaw_vrc = 1024.0 + plant.yaw_rate.trim_counts});
  std::shared_ptr<hal::Uart> pose_line;
  std::optional<sim::PoseSender> pose;
  if (!pose_name.empty()) {
    pose_line = serial_end(pose_name, hal::is_simulated(pose_name) ? kPoseBaud : 0);
    pose.emplace(*pose_line, plant, options.seed);
  }
  std::cout << "autopilot on " << (own_world ? "sim:" + options.simulated : options.pty) << ", " << options.baud
            << " baud, mode switch at " << options.mode << std::endl;
  hal::PortClock clock(name);
  fly(options, clock, autopilot, vehicle, pose ? &*pose : nullptr, events ? &*events : nullptr);
}

}  // namespace m100::lab::autopilot
