// SPDX-License-Identifier: BSD-3-Clause
// Damage that a checksum detects costs single frames and must not end a flight.
#include <array>
#include <vector>

#include "host_tests/scenario/authority/catalogue.h"

namespace m100::authority {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kOtherBaud = 115200;

void plan_false_headers(Bench& bench, int left) {
  bench.to_client.inject(false_header(), bench.now());
  if (left > 0) {
    bench.plan(milliseconds(100), [&bench, left] { plan_false_headers(bench, left - 1); });
  }
}

void garble(Bench& bench, bool on) {
  const std::uint32_t baud = bench.setup().baud;
  for (StreamFaultInjector* const way : {&bench.to_client, &bench.to_autopilot}) {
    way->plan.sent_at = on ? baud : 0;
    way->plan.received_at = on ? kOtherBaud : 0;
  }
}

/// Repeated overruns of the driver's buffer: each removes a piece from the middle of the received bytes.
void plan_overruns(Bench& bench, int left) {
  bench.to_client.plan.swallow = 100;
  if (left > 0) {
    bench.plan(milliseconds(250), [&bench, left] { plan_overruns(bench, left - 1); });
  }
}

void cut(Bench& bench, bool to_client, bool to_autopilot) {
  bench.to_client.plan.cut = to_client;
  bench.to_autopilot.plan.cut = to_autopilot;
}

void shake_hands(Setup& setup) { setup.handshake = true; }

void make_noise(Bench& bench) {
  sim::Random random(bench.setup().seed, "noise");
  std::vector<std::byte> noise(200);
  for (std::byte& byte : noise) {
    byte = static_cast<std::byte>(random.next() >> 56U);
  }
  bench.to_client.inject(noise, bench.now());
  bench.to_autopilot.inject(noise, bench.now());
}

void run_of_start_bytes(Bench& bench) {
  const std::vector<std::byte> run(300, std::byte{0xAA});
  bench.to_client.inject(run, bench.now());
  bench.to_autopilot.inject(run, bench.now());
}

constexpr std::array kFaults{
    Fault{.name = "pieces lost, 5 %",
          .strike = [](Bench& b) { b.to_client.plan.drop = b.to_autopilot.plan.drop = 0.05; }},
    Fault{.name = "pieces lost, 10 %",
          .strike = [](Bench& b) { b.to_client.plan.drop = b.to_autopilot.plan.drop = 0.10; }},
    Fault{.name = "pieces in fragments",
          .strike = [](Bench& b) { b.to_client.plan.in_fragments = b.to_autopilot.plan.in_fragments = true; },
          .flies_on = true},
    Fault{
        .name = "our buffer overruns, 4 a second", .strike = [](Bench& b) { plan_overruns(b, 40); }, .flies_on = true},
    Fault{.name = "pieces doubled",
          .strike = [](Bench& b) { b.to_client.plan.twice = b.to_autopilot.plan.twice = 0.1; }},
    Fault{.name = "pieces out of order",
          .strike = [](Bench& b) { b.to_client.plan.swapped = b.to_autopilot.plan.swapped = 0.1; }},
    Fault{.name = "bits flipped, 1e-5",
          .strike = [](Bench& b) { b.to_client.plan.flip_per_bit = b.to_autopilot.plan.flip_per_bit = 1e-5; },
          .flies_on = true},
    Fault{.name = "bits flipped, 3e-2",
          .strike = [](Bench& b) { b.to_client.plan.flip_per_bit = b.to_autopilot.plan.flip_per_bit = 3e-2; },
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { b.to_client.plan.flip_per_bit = b.to_autopilot.plan.flip_per_bit = 0.0; }},
    Fault{.name = "frames cut short",
          .strike = [](Bench& b) { b.to_client.plan.swallow = b.to_autopilot.plan.swallow = 7; },
          .flies_on = true},
    Fault{.name = "burst of noise", .strike = make_noise, .flies_on = true},
    Fault{.name = "run of start bytes", .strike = run_of_start_bytes, .flies_on = true},
    Fault{
        .name = "false headers, 10 a second", .strike = [](Bench& b) { plan_false_headers(b, 100); }, .flies_on = true},
    Fault{.name = "wrong baud rate",
          .strike = [](Bench& b) { garble(b, true); },
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { garble(b, false); }},
    Fault{.name = "0.3 s late both ways",
          .strike = [](Bench& b) { b.to_client.plan.delay = b.to_autopilot.plan.delay = milliseconds(300); },
          .reach = FaultReach::kLate},
    Fault{.name = "jitter of 30 ms both ways",
          .strike = [](Bench& b) { b.to_client.plan.jitter = b.to_autopilot.plan.jitter = milliseconds(30); }},
    Fault{.name = "nothing reaches us",
          .strike = [](Bench& b) { cut(b, true, false); },
          .within_s = kSilentLink_s,
          .reach = FaultReach::kDeaf},
    Fault{.name = "nothing reaches us for 0.3 s",
          .strike = [](Bench& b) { cut(b, true, false); },
          .heals_after_s = 0.3,
          .heal = [](Bench& b) { cut(b, false, false); }},
    Fault{.name = "nothing of ours arrives for 4 s",
          .strike = [](Bench& b) { cut(b, false, true); },
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { cut(b, false, false); }},
    Fault{.name = "line cut for 4 s",
          .strike = [](Bench& b) { cut(b, true, true); },
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { cut(b, false, false); }},
    // Intact frames with old content. Telemetry that does not change counts as a silent line.
    Fault{.name = "telemetry stands still",
          .strike = [](Bench& b) { b.to_client.plan.telemetry_stands_still = true; },
          .within_s = kSilentLink_s,
          .reach = FaultReach::kDeaf},
    Fault{.name = "telemetry comes once more 0.2 s late",
          .strike = [](Bench& b) { b.to_client.plan.telemetry_again_after = milliseconds(200); },
          .flies_on = true},
    Fault{.name = "no telemetry for 0.3 s", .strike = [](Bench& b) { b.send_to_autopilot("silence 0.3"); }},
    Fault{.name = "no telemetry for 3 s",
          .strike = [](Bench& b) { b.send_to_autopilot("silence 3"); },
          .within_s = kSilentLink_s},
    // The handshake on the bench must end by the same rules as a flight.
    Fault{.name = "handshake, nothing of its own arrives for 4 s",
          .strike = [](Bench& b) { cut(b, false, true); },
          .stages = bit(Stage::kFlying),
          .within_s = kSilentLink_s,
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { cut(b, false, false); },
          .prepare = shake_hands,
          .ends_program = true},
    Fault{.name = "handshake, line cut for 4 s",
          .strike = [](Bench& b) { cut(b, true, true); },
          .stages = bit(Stage::kFlying),
          .within_s = kSilentLink_s,
          .reach = FaultReach::kMute,
          .heals_after_s = 4.0,
          .heal = [](Bench& b) { cut(b, false, false); },
          .prepare = shake_hands,
          .ends_program = true},
};

}  // namespace

std::span<const Fault> line_faults() {
  static constexpr std::array kAll = of_group(Group::kLine, kFaults);
  return kAll;
}

}  // namespace m100::authority
