// SPDX-License-Identifier: BSD-3-Clause
#include <signal.h>

#include <array>

#include "host_tests/scenario/authority/catalogue.h"

namespace m100::authority {
namespace {

using std::chrono::milliseconds;

constexpr std::uint8_t kNotReleasing = kAnyStage & static_cast<std::uint8_t>(~bit(Stage::kReleasing));

void stall(Bench& bench, milliseconds time) {
  // In real time only a signal can stop a program; a second signal resumes it.
  bench.stop_client_at_the_signal(true);
  bench.plan(time, [&bench] { bench.stop_client_at_the_signal(false); });
}

template <int Signal>
void send_signal(Bench& bench) {
  bench.client().send(Signal);
}

/// A signal with which an operator or the system asks the program to end.
template <int Signal>
constexpr Fault stopped_by(std::string_view name) {
  return {.name = name,
          .strike = send_signal<Signal>,
          .stages = kNotReleasing,
          .within_s = kChange_s,
          .ends_program = true};
}

constexpr std::array kFaults{
    stopped_by<SIGINT>("SIGINT"),
    stopped_by<SIGTERM>("SIGTERM"),
    stopped_by<SIGHUP>("SIGHUP"),
    stopped_by<SIGQUIT>("SIGQUIT"),
    Fault{.name = "SIGKILL", .strike = send_signal<SIGKILL>, .within_s = kDeath_s, .ends_program = true},
    Fault{.name = "SIGSEGV", .strike = send_signal<SIGSEGV>, .within_s = kDeath_s, .ends_program = true},
    Fault{.name = "SIGABRT", .strike = send_signal<SIGABRT>, .within_s = kDeath_s, .ends_program = true},
    Fault{.name = "SIGSTOP",
          .strike = [](Bench& b) { b.stop_client_at_the_signal(true); },
          .within_s = kDeath_s,
          .ends_program = true},
    Fault{.name = "SIGSTOP for 3 s", .strike = [](Bench& b) { stall(b, milliseconds(3000)); }, .within_s = kDeath_s},
    Fault{.name = "stall of 0.1 s", .strike = [](Bench& b) { stall(b, milliseconds(100)); }, .flies_on = true},
    Fault{.name = "stall of 0.4 s", .strike = [](Bench& b) { stall(b, milliseconds(400)); }},
    Fault{.name = "stall of 0.8 s", .strike = [](Bench& b) { stall(b, milliseconds(800)); }, .within_s = 0.8 + 1.0},
    Fault{.name = "stall of 2 s", .strike = [](Bench& b) { stall(b, milliseconds(2000)); }, .within_s = kDeath_s},
    // The process that would give control back after a death of the program is gone. The flight continues, and the
    // operator is told.
    Fault{.name = "second process killed",
          .strike = [](Bench& b) { b.send_to_backup(SIGKILL); },
          .flies_on = true,
          .kills_backup = true},
    Fault{.name = "second process stopped",
          .strike = [](Bench& b) { b.send_to_backup(SIGSTOP); },
          .flies_on = true,
          .kills_backup = true},
    Fault{.name = "the hold is over",
          .strike = [](Bench&) {},
          .stages = bit(Stage::kFlying),
          .within_s = kChange_s + 0.1,  // the program counts from its notice of the grant, the case from the grant
          .prepare = [](Setup& s) { s.hold_s = 3.0; },
          .ends_program = true},
    Fault{.name = "operator presses Enter",
          .strike = [](Bench& b) { b.client().type("\n"); },
          .stages = kInFlight,
          .within_s = kChange_s,
          .ends_program = true},
    Fault{.name = "standard input closed", .strike = [](Bench& b) { b.client().close_input(); }, .flies_on = true},
    Fault{.name = "output closed from the start",
          .strike = [](Bench&) {},
          .stages = bit(Stage::kFlying),
          .prepare = [](Setup& s) { s.streams.output_closed = true; },
          .flies_on = true},
    Fault{.name = "log may not grow",
          .strike = [](Bench&) {},
          .stages = bit(Stage::kFlying) | bit(Stage::kReleasing),
          .prepare =
              [](Setup& s) {
                s.more_words.insert(s.more_words.end(), {"--log", "%/flight.ulg"});
                s.streams.file_limit_bytes = 256L * 1024;
              },
          .flies_on = true},
    Fault{.name = "log onto a file system that fills up",
          .strike = [](Bench&) {},
          .stages = bit(Stage::kFlying) | bit(Stage::kReleasing),
          .prepare =
              [](Setup& s) {
                s.more_words.insert(s.more_words.end(), {"--log", "%/disk/flight.ulg", "--json", "%/disk/result.json"});
                s.streams.small_disk = "%/disk";
              },
          .flies_on = true,
          .needs_mount = true},
    Fault{.name = "result onto a full disk",
          .strike = [](Bench&) {},
          .stages = bit(Stage::kFlying) | bit(Stage::kReleasing),
          .prepare =
              [](Setup& s) {
                s.more_words.insert(s.more_words.end(), {"--json", "/dev/full"});
              },
          .flies_on = true},
};

}  // namespace

std::span<const Fault> process_faults() {
  static constexpr std::array kAll = of_group(Group::kProcess, kFaults);
  return kAll;
}

}  // namespace m100::authority
