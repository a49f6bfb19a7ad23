// SPDX-License-Identifier: BSD-3-Clause
// m100-lab autopilot: an N1 autopilot with a vehicle behind it, on a pseudo-terminal, in real time.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

#include "hal/linux/monotonic_clock.h"
#include "host_tests/sim/emulated_board.h"
#include "host_tests/sim/n1_autopilot.h"
#include "host_tests/sim/plant_file.h"
#include "host_tests/sim/pose_source.h"
#include "host_tests/sim/pty_uart.h"
#include "host_tests/sim/vehicle.h"
#include "host_tests/sim/world.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/subcommands.h"
#include "protocol/aes256.h"
#include "protocol/pose_message.h"

namespace m100::tools {
namespace {

volatile std::sig_atomic_t stop_asked = 0;
void ask_to_stop(int) { stop_asked = 1; }

struct Options {
  std::string pty;
  std::string pose_pty;
  std::string board;
  std::string course = "hover";
  std::string plant;
  std::uint64_t seed = 1;
  std::string mode = "F";
  std::string script;
  std::string events;
  std::uint32_t baud = 230400;
  std::uint32_t app_id = 0;
  std::string key;
  double loss = 0.0;
  double duration_s = 0.0;
  bool lenient_virtual_rc = false;
};

std::string read_text(const std::string& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw InputError(path, 0, "", "cannot be read");
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::vector<sim::N1ScriptLine> read_script(const std::string& path) {
  try {
    return sim::read_n1_script(read_text(path));
  } catch (const sim::N1ScriptError& wrong) {
    throw InputError(path, wrong.line(), "", wrong.what());
  }
}

protocol::CipherKey read_key(const std::string& hex) {
  protocol::CipherKey key{};
  if (hex.size() != 2 * key.size() || hex.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw InputError("--key", 0, "", "needs 64 hexadecimal digits");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  return key;
}

/// JSON lines; the last one sums up what a strict examiner saw.
class EventFile {
 public:
  explicit EventFile(const std::string& path) : file_(path) {
    if (!file_) {
      throw InputError(path, 0, "", "cannot be written");
    }
  }
  void write(const sim::N1Event& event) {
    file_ << "{\"t_s\":" << core::seconds<double>(event.at.time_since_epoch()) << ",\"what\":\"" << event.what
          << "\",\"name\":\"" << event.name << "\",\"value\":" << event.value << "}\n"
          << std::flush;  // for whoever follows the file
  }
  /// @param longest_lag the machine kept the autopilot waiting: its own stamps are late by up to that.
  void summarise(const sim::N1Autopilot& autopilot, core::Duration longest_lag) {
    const sim::N1Record& record = autopilot.record();
    const protocol::ParserStats& parser = autopilot.parser_stats();
    const auto spacing_s = [](core::Duration spacing) {
      return spacing == core::Duration::max() ? -1.0 : core::seconds<double>(spacing);  // -1: there were not two
    };
    file_ << "{\"what\":\"summary\",\"obtain_requests\":" << record.obtain_requests
          << ",\"least_obtain_spacing_s\":" << spacing_s(record.least_obtain_spacing)
          << ",\"virtual_rc_on_requests\":" << record.virtual_rc_on_requests
          << ",\"least_on_spacing_s\":" << spacing_s(record.least_on_spacing)
          << ",\"movement_taken\":" << record.movement_taken << ",\"movement_ignored\":" << record.movement_ignored
          << ",\"virtual_rc_taken\":" << record.virtual_rc_taken
          << ",\"virtual_rc_ignored\":" << record.virtual_rc_ignored
          << ",\"most_commands_per_s\":" << record.most_commands_per_s << ",\"losses\":" << record.losses
          << ",\"control_after_loss\":" << record.control_after_loss
          << ",\"latest_after_loss_s\":" << core::seconds<double>(record.latest_after_loss)
          << ",\"telemetry_packages\":" << record.telemetry_packages << ",\"bad_commands\":" << record.bad_commands
          << ",\"frames\":" << parser.frames << ",\"crc16_errors\":" << parser.crc16_errors
          << ",\"crc32_errors\":" << parser.crc32_errors << ",\"bytes_dropped\":" << parser.bytes_dropped
          << ",\"longest_lag_s\":" << core::seconds<double>(longest_lag)
          << ",\"client_in_control\":" << (autopilot.client_in_control() ? "true" : "false") << "}\n";
    file_.flush();
  }

 private:
  std::ofstream file_;
};

/// The motion capture beside the autopilot, if there is one: pose messages on a pseudo-terminal of their own.
class PosePty {
 public:
  PosePty(const std::string& link, const sim::Plant& plant, std::uint64_t seed)
      : uart_(link), source_(plant.sensors, seed) {}

  void step(core::TimePoint now, const sim::Vehicle& vehicle) {
    while (const auto sample = source_.step(now, vehicle.state(), vehicle.attitude().yaw_rad)) {
      const core::Quaternion<double> q = core::quaternion_of(core::Euler<double>{.yaw_rad = sample->yaw_rad});
      const protocol::PoseMessage message{
          .sequence = ++sequence_,
          .age_us = static_cast<std::uint32_t>((now - sample->captured).count()),
          .position_w_m = {static_cast<float>(sample->position_w_m.x()), static_cast<float>(sample->position_w_m.y()),
                           static_cast<float>(sample->position_w_m.z())},
          .rotation_wb = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                          static_cast<float>(q.z)}};
      (void)uart_.write(protocol::encode(message));
    }
  }

 private:
  sim::PtyUart uart_;
  sim::PoseSource source_;
  std::uint32_t sequence_ = 0;
};

/// The flight image in the emulator instead of a pseudo-terminal: UART1 is the autopilot's line, UART2 the pose, and
/// the simulation leads it through time. The operator asks for control after 6 s and gives it back 3 s before the end.
void run_with_board(const Options& options, const sim::Plant& plant, const sim::N1Config& config) {
  sim::World world(plant, {.seed = options.seed, .autopilot = config});
  std::optional<EventFile> events;
  if (!options.events.empty()) {
    events.emplace(options.events);
    world.autopilot().on_event([&](const sim::N1Event& event) { events->write(event); });
  }
  world.autopilot().happen(sim::N1Happening::kLoss, options.loss);
  sim::EmulatedBoard board(options.board, "lockstep " + options.course);
  const int ticks = static_cast<int>((options.duration_s > 0.0 ? options.duration_s : 30.0) * 100.0);
  const core::Vector<double, 3> start = world.vehicle().state().position_w_m;
  double farthest_m = 0.0;
  for (int tick = 0; tick < ticks && stop_asked == 0; ++tick) {
    world.advance(core::kTickPeriod);
    const hal::LockstepOrder order =
        tick == 600 ? hal::LockstepOrder::kEngage
                    : (tick == ticks - 300 ? hal::LockstepOrder::kRelease : hal::LockstepOrder::kNone);
    board.step(world.now(), order, world.autopilot_uart(), world.pose_uart());
    farthest_m = std::max(farthest_m, (world.vehicle().state().position_w_m - start).norm());
  }
  std::cout << options.course << " flown by " << options.board << ": " << world.autopilot().record().virtual_rc_taken
            << " stick commands taken, at most " << farthest_m << " m from the start, exit status " << board.end()
            << std::endl;
  if (events) {
    events->summarise(world.autopilot(), core::Duration{0});
  }
}

void run(const Options& options) {
  if (std::isnan(options.duration_s) || std::isnan(options.loss)) {  // passes every comparison of a range
    throw InputError(std::isnan(options.loss) ? "--loss" : "--duration", 0, "", "is not a number");
  }
  const sim::Plant plant = options.plant.empty() ? sim::measured_plant() : sim::load_plant(options.plant);
  std::optional<protocol::Aes256> cipher;
  if (!options.key.empty()) {
    cipher.emplace(read_key(options.key));
  }
  sim::N1Config config{.baud = options.baud,
                       .seed = options.seed,
                       .mode = static_cast<sim::N1Mode>(options.mode.front()),
                       .cipher = cipher ? &*cipher : nullptr,
                       .app_id = options.app_id,
                       .noise = {.attitude_rad = plant.sensors.attitude_noise_rad,
                                 .rate_rad_s = plant.sensors.imu_rate_noise_rad_s,
                                 .force_m_s2 = plant.sensors.imu_acceleration_noise_m_s2},
                       .lenient_virtual_rc = options.lenient_virtual_rc};
  if (!options.script.empty()) {
    config.script = read_script(options.script);
  }
  if (!options.board.empty()) {
    run_with_board(options, plant, config);
    return;
  }
  std::optional<EventFile> events;
  if (!options.events.empty()) {
    events.emplace(options.events);
  }
  if (options.pose_pty == options.pty) {
    throw InputError("--pose-pty", 0, "", "must not be the link of --pty");
  }
  sim::PtyUart uart(options.pty);
  sim::Vehicle vehicle(plant, options.seed, {0.0, 0.0, 1.5});
  sim::N1Autopilot autopilot(uart, vehicle, config);
  autopilot.happen(sim::N1Happening::kLoss, options.loss);
  if (events) {
    autopilot.on_event([&](const sim::N1Event& event) { events->write(event); });
  }
  // The pilot holds the aircraft at the balancing point of its sticks until the client takes over.
  autopilot.set_pilot_sticks({.roll_vrc = 1024.0 + plant.roll.trim_counts,
                              .pitch_vrc = 1024.0 + plant.pitch.trim_counts,
                              .throttle_vrc = 1024.0 + plant.climb.trim_counts,
                              .yaw_vrc = 1024.0 + plant.yaw_rate.trim_counts});
  std::optional<PosePty> pose;
  if (!options.pose_pty.empty()) {
    pose.emplace(options.pose_pty, plant, options.seed);
  }
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::cout << "autopilot on " << options.pty << ", " << options.baud << " baud, mode switch at " << options.mode
            << std::endl;
  hal::MonotonicClock clock;
  const core::TimePoint end{core::Duration{static_cast<std::int64_t>(options.duration_s * 1e6)}};
  core::TimePoint last = clock.now();
  core::Duration longest_lag{0};
  for (core::TimePoint now = last; stop_asked == 0 && (options.duration_s <= 0.0 || now < end); now = clock.now()) {
    longest_lag = std::max(longest_lag, now - last);
    last = now;
    autopilot.advance(now);
    if (pose) {
      pose->step(now, vehicle);
    }
    clock.sleep_until(now + sim::N1Autopilot::kTick);
  }
  if (events) {
    events->summarise(autopilot, longest_lag);
  }
}

}  // namespace

void add_autopilot(CLI::App& lab) {
  CLI::App* app = lab.add_subcommand("autopilot", "emulate an N1 autopilot with a vehicle on a pseudo-terminal");
  auto options = std::make_shared<Options>();
  app->add_option("--pty", options->pty, "symbolic link to make; clients open it like a serial port");
  app->add_option("--pose-pty", options->pose_pty, "a second link, with the pose of the vehicle at 100 Hz");
  app->add_option(
         "--board", options->board,
         "flight image to run in QEMU instead (m100_mps2.elf): its UART1 is the line, its UART2 the pose, in lockstep")
      ->check(CLI::ExistingFile)
      ->excludes("--pty");
  app->add_option("--course", options->course, "of the board")
      ->check(CLI::IsMember({"hover", "step", "trajectory"}))
      ->needs("--board");
  app->add_option("--plant", options->plant, "plant file (TOML); default: the measured aircraft");
  app->add_option("--seed", options->seed, "of every noise");
  app->add_option("--rc-mode", options->mode, "mode switch of the remote controller at the start")
      ->check(CLI::IsMember({"F", "A", "P"}));
  app->add_option(
      "--script", options->script,
      "what happens when: lines of SECONDS WHAT [VALUE], e.g. '12.5 mode A', '20 take mobile', '25 restart'");
  app->add_option("--events", options->events, "JSON lines of what it received and did; the last one sums up");
  app->add_option("--baud", options->baud, "line rate to keep to, both ways; 0: as fast as it goes")
      ->check(CLI::IsMember({0, 115200, 230400, 460800, 921600}));
  app->add_option("--app-id", options->app_id, "the only app id to activate; default: any");
  app->add_option("--key", options->key, "AES key of the app, 64 hexadecimal digits");
  app->add_option("--loss", options->loss, "share of frames lost, each way")->check(CLI::Range(0.0, 1.0));
  app->add_option("--duration", options->duration_s, "seconds; default: until interrupted")
      ->check(CLI::Range(0.001, 1e6));
  app->add_flag("--lenient-virtual-rc", options->lenient_virtual_rc,
                "take 64 bytes under the on/off id as data, as clients of SDK 3.3 to 4.1 send them");
  app->callback([options] {
    if (options->pty.empty() && options->board.empty()) {
      throw InputError("--pty", 0, "", "or --board is needed");
    }
    run(*options);
  });
}

}  // namespace m100::tools
