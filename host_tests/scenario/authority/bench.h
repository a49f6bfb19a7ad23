// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/scenario/authority/cable.h"
#include "host_tests/scenario/authority/events.h"
#include "host_tests/scenario/authority/other_autopilot.h"
#include "host_tests/scenario/authority/program.h"
#include "host_tests/scenario/authority/stream_fault_injector.h"

namespace m100::authority {

/// Where the programs and their files are.
struct Places {
  std::string m100;
  std::string lab;
  std::string vehicle;
  std::string gains;
  std::string folder;  ///< of this case; must be empty
  bool keep = false;   ///< keeps the files even if the case passed
};

/// Settings with which the two programs are started.
struct Setup {
  bool movement = false;
  bool encrypted = false;
  bool real_time = false;
  bool handshake = false;  ///< m100 handshake instead of m100 fly
  double hold_s = 600.0;
  std::uint64_t seed = 1;
  std::uint32_t baud = 230400;
  std::vector<std::string> more_words{};  ///< of m100
  Program::Streams streams{};             ///< of m100
};

/// The installed programs, `m100 fly` and `m100-lab autopilot`, with a man in the middle on both lines.
class Bench {
 public:
  Bench(Places places, Setup setup);
  ~Bench();
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// Starts the autopilot and waits until its time runs. @throws std::runtime_error
  void start_autopilot();
  void start_client();
  /// One step: time, bytes, and the actions planned for now.
  void step();
  core::TimePoint now() { return cable_->now(); }
  /// The autopilot's own time, as in its events.
  double autopilot_s();
  void plan(core::Duration from_now, std::function<void()> action);

  /// Executes a line of the autopilot's script now.
  void send_to_autopilot(const std::string& line);
  void stop_client_at_the_signal(bool stopped);  ///< sends SIGSTOP or SIGCONT, also to its simulated time
  void send_to_backup(int signal);               ///< signals the second process of m100 fly
  /// Puts another autopilot at the client's port; the caller plugs it in.
  void replace_autopilot() { other_.emplace(setup_.baud, now()); }
  /// @returns the other autopilot; empty if there is none.
  const std::optional<OtherAutopilot>& other() const { return other_; }
  Program& client() { return *client_; }
  /// Waits for the client's end: a process leaves simulated time before it is gone, on a busy machine long before.
  void let_client_end();
  Cable& cable() { return *cable_; }
  Events& events() { return events_; }
  const Setup& setup() const { return setup_; }
  /// All output of m100.
  std::string said() const;
  /// Lets the autopilot write its summary and end. @returns false if it did not.
  bool finish();

  StreamFaultInjector to_client;
  StreamFaultInjector to_autopilot;
  StreamFaultInjector poses;
  PoseFaultInjector pose_messages;

 private:
  void carry();
  std::vector<std::string> client_words() const;
  std::vector<std::string> autopilot_words() const;

  struct Planned {
    core::TimePoint when;
    std::function<void()> action;
  };
  Places places_;
  Setup setup_;
  std::unique_ptr<Cable> cable_;
  std::unique_ptr<Program> autopilot_;
  std::unique_ptr<Program> client_;
  Events events_;
  std::optional<OtherAutopilot> other_;
  std::vector<Planned> planned_;
  double behind_s_ = kNever_s;  ///< by which the autopilot's clock lags ours
};

}  // namespace m100::authority
