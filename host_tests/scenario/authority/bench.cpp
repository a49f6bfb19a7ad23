// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/bench.h"

#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

namespace m100::authority {
namespace {

constexpr char kFolderMark = '%';  // stands for the client's folder in its arguments
constexpr const char* kKey = "00112233445566778899aabbccddeeff0123456789abcdef0123456789abcdef";
constexpr const char* kFlightFile =
    "[fence]\nx_m = [-10.0, 10.0]\ny_m = [-10.0, 10.0]\nz_m = [0.3, 5.0]\n[wind]\nclass_m_s = 5.0\n";

double seconds_of(core::TimePoint at) { return core::seconds<double>(at.time_since_epoch()); }

}  // namespace

Bench::Bench(Places places, Setup setup)
    : to_client(setup.seed + 11),
      to_autopilot(setup.seed + 12),
      poses(setup.seed + 13),
      places_(std::move(places)),
      setup_(std::move(setup)),
      events_(places_.folder + "/events.json") {
  std::ofstream(places_.folder + "/flight.toml") << kFlightFile;
  const std::string key = places_.folder + "/key";
  std::ofstream(key) << kKey << "\n";
  std::filesystem::permissions(key, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

Bench::~Bench() {
  client_.reset();
  autopilot_.reset();
  end_all_in(places_.folder);
}

std::vector<std::string> Bench::autopilot_words() const {
  const bool real = setup_.real_time;
  const std::string line = real ? places_.folder + "/n1" : cable_->port_of(End::kAutopilot);
  const std::string pose = real ? places_.folder + "/n1_pose" : cable_->port_of(End::kAutopilotPose);
  std::vector<std::string> words{places_.lab,  "autopilot",
                                 "--pty",      line,
                                 "--pose-pty", pose,
                                 "--events",   places_.folder + "/events.json",
                                 "--baud",     std::to_string(setup_.baud),
                                 "--seed",     std::to_string(setup_.seed),
                                 "--script",   "-"};
  if (setup_.encrypted) {
    words.insert(words.end(), {"--key-file", places_.folder + "/key"});
  }
  return words;
}

std::vector<std::string> Bench::client_words() const {
  std::vector<std::string> words{places_.m100, setup_.handshake ? "handshake" : "fly",
                                 "--port",     cable_->port_of(End::kClient),
                                 "--baud",     std::to_string(setup_.baud),
                                 "--channel",  setup_.movement ? "movement" : "virtual_rc",
                                 "--hold",     std::to_string(setup_.hold_s)};
  if (!setup_.handshake) {
    words.insert(words.end(),
                 {"--pose-port", cable_->port_of(End::kClientPose), "--vehicle", places_.vehicle, "--gains",
                  places_.gains, "--flight", places_.folder + "/flight.toml", "--take-control"});
  }
  if (setup_.encrypted) {
    words.insert(words.end(), {"--key-file", places_.folder + "/key"});
  }
  for (std::string word : setup_.more_words) {
    const std::size_t at = word.find(kFolderMark);
    words.push_back(at == std::string::npos ? word : word.replace(at, 1, places_.folder));
  }
  return words;
}

void Bench::start_autopilot() {
  if (setup_.real_time) {
    cable_ = std::make_unique<RealCable>(places_.folder, setup_.baud);
  } else {
    cable_ = std::make_unique<SimulatedCable>(places_.folder);
  }
  autopilot_ =
      std::make_unique<Program>(autopilot_words(), Program::Streams{.said = places_.folder + "/autopilot.txt"});
  if (!cable_->wait_for(autopilot_->id())) {
    throw std::runtime_error("the autopilot did not start: " + places_.folder + "/autopilot.txt");
  }
}

void Bench::start_client() {
  Program::Streams streams = setup_.streams;
  streams.said = places_.folder + "/said.txt";
  if (!streams.small_disk.empty()) {
    streams.small_disk.replace(streams.small_disk.find(kFolderMark), 1, places_.folder);
    std::filesystem::create_directories(streams.small_disk);
  }
  client_ = std::make_unique<Program>(client_words(), streams);
  if (!setup_.real_time) {
    (void)cable_->wait_for(client_->id());  // a program that refuses its arguments never takes part
  }
}

void Bench::carry() {
  const core::TimePoint at = now();
  if (other_) {
    (void)cable_->take(End::kAutopilot);
    to_client.take(other_->talk(cable_->take(End::kClient), at), at);
  } else {
    to_client.take(cable_->take(End::kAutopilot), at);
    to_autopilot.take(cable_->take(End::kClient), at);
  }
  poses.take(pose_messages.pass(cable_->take(End::kAutopilotPose), at), at);
  cable_->give(End::kClient, to_client.due(at));
  cable_->give(End::kAutopilot, to_autopilot.due(at));
  cable_->give(End::kClientPose, poses.due(at));
  (void)cable_->take(End::kClientPose);
}

void Bench::step() {
  cable_->advance();
  carry();
  if (events_.poll()) {
    behind_s_ = std::min(behind_s_, seconds_of(now()) - events_.now_s());
  }
  for (std::size_t i = 0; i < planned_.size();) {
    if (planned_[i].when <= now()) {
      const std::function<void()> action = std::move(planned_[i].action);
      planned_.erase(planned_.begin() + static_cast<std::ptrdiff_t>(i));
      action();  // may plan further actions
    } else {
      ++i;
    }
  }
}

double Bench::autopilot_s() { return seconds_of(now()) - (setup_.real_time && behind_s_ < kNever_s ? behind_s_ : 0.0); }

void Bench::plan(core::Duration from_now, std::function<void()> action) {
  planned_.push_back({now() + from_now, std::move(action)});
}

void Bench::send_to_autopilot(const std::string& line) { autopilot_->type("0 " + line + "\n"); }

void Bench::stop_client_at_the_signal(bool stopped) {
  if (stopped) {
    cable_->suspend(client_->id());
    client_->send(SIGSTOP);
  } else {
    client_->send(SIGCONT);
    cable_->resume(client_->id());
  }
}

void Bench::let_client_end() {
  constexpr int kWaits = 3000;  // 10 ms each
  for (int wait = 0; wait < kWaits && client_->runs() && !cable_->takes_part(client_->id()); ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void Bench::send_to_backup(int signal) {
  const pid_t backup = client_->child("m100-backup");
  if (backup <= 0) {
    throw std::runtime_error("m100 fly has no second process");
  }
  if (signal == SIGSTOP) {
    cable_->suspend(backup);
  }
  ::kill(backup, signal);
}

std::string Bench::said() const {
  std::ifstream file(places_.folder + "/said.txt");
  return std::string(std::istreambuf_iterator<char>(file), {});
}

bool Bench::finish() {
  autopilot_->send(SIGTERM);
  for (int steps = 0; steps < 5000 && events_.summary().is_null(); ++steps) {
    cable_->advance();
    (void)events_.poll();
  }
  return !events_.summary().is_null();
}

}  // namespace m100::authority
