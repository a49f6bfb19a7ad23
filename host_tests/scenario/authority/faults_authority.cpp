// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "host_tests/scenario/authority/catalogue.h"

namespace m100::authority {
namespace {

using std::chrono::milliseconds;

constexpr std::array kFaults{
    Fault{.name = "mode switch to A",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("mode A"); },
          .within_s = kChange_s,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.send_to_autopilot("mode F"); }},
    Fault{.name = "mode switch to P",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("mode P"); },
          .within_s = kChange_s},
    Fault{.name = "taken by the pilot",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("take rc"); },
          .within_s = kChange_s},
    Fault{.name = "taken by the app",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("take mobile"); },
          .within_s = kChange_s,
          .reach = FaultReach::kTaken,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.send_to_autopilot("take rc"); }},
    Fault{.name = "autopilot restarts",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("restart"); },
          .within_s = kChange_s},
    Fault{.name = "Virtual RC ended",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("end_virtual_rc"); }},
    Fault{.name = "transmitter off",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("rc off"); }},
    Fault{.name = "IOC switched on",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("ioc on"); }},
    Fault{.name = "every answer lost",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000"); }},
    Fault{.name = "answers to requests lost",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000 obtain_control"); }},
    Fault{.name = "answers to releases lost",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000 release_control"); }},
    Fault{.name = "answers 0.7 s late",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("delay_acks 0.7"); }},
    Fault{.name = "answers doubled",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.send_to_autopilot("double_acks 1000"); },
          .flies_on = true},
    Fault{.name = "answers of another session",
          .group = Group::kAuthority,
          .strike = [](Bench& b) { b.to_client.plan.strange_answers = true; },
          .flies_on = true},
    // The port.
    Fault{.name = "unplugged for 0.4 s",
          .group = Group::kPort,
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute,
          .heals_after_s = 0.4,
          .heal = [](Bench& b) { b.cable().plug_in(End::kClient); }},
    Fault{.name = "unplugged for 3 s",
          .group = Group::kPort,
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.cable().plug_in(End::kClient); }},
    Fault{.name = "unplugged for good",
          .group = Group::kPort,
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute},
    Fault{.name = "another autopilot plugged in",
          .group = Group::kPort,
          .strike =
              [](Bench& b) {
                b.cable().unplug(End::kClient);
                b.plan(milliseconds(1500), [&b] {
                  b.replace_autopilot();
                  b.cable().plug_in(End::kClient);
                });
              },
          .stages = bit(Stage::kAsking) | kInFlight,
          .reach = FaultReach::kMute},
};

}  // namespace

std::span<const Fault> authority_faults() { return kFaults; }

}  // namespace m100::authority
