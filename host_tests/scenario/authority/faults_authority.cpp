// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "host_tests/scenario/authority/catalogue.h"

namespace m100::authority {
namespace {

using std::chrono::milliseconds;

constexpr std::array kFaults{
    Fault{.name = "mode switch to A",
          .strike = [](Bench& b) { b.send_to_autopilot("mode A"); },
          .within_s = kChange_s,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.send_to_autopilot("mode F"); }},
    Fault{.name = "mode switch to P", .strike = [](Bench& b) { b.send_to_autopilot("mode P"); }, .within_s = kChange_s},
    Fault{.name = "taken by the pilot",
          .strike = [](Bench& b) { b.send_to_autopilot("take rc"); },
          .within_s = kChange_s},
    Fault{.name = "taken by the app",
          .strike = [](Bench& b) { b.send_to_autopilot("take mobile"); },
          .within_s = kChange_s,
          .reach = FaultReach::kTaken,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.send_to_autopilot("take rc"); }},
    Fault{.name = "autopilot restarts",
          .strike = [](Bench& b) { b.send_to_autopilot("restart"); },
          .within_s = kChange_s},
    Fault{.name = "Virtual RC ended", .strike = [](Bench& b) { b.send_to_autopilot("end_virtual_rc"); }},
    Fault{.name = "transmitter off", .strike = [](Bench& b) { b.send_to_autopilot("rc off"); }},
    Fault{.name = "IOC switched on", .strike = [](Bench& b) { b.send_to_autopilot("ioc on"); }},
    Fault{.name = "every answer lost", .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000"); }},
    Fault{.name = "answers to requests lost",
          .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000 obtain_control"); }},
    Fault{.name = "answers to releases lost",
          .strike = [](Bench& b) { b.send_to_autopilot("lose_acks 1000 release_control"); }},
    Fault{.name = "answers 0.7 s late", .strike = [](Bench& b) { b.send_to_autopilot("delay_acks 0.7"); }},
    Fault{.name = "answers doubled",
          .strike = [](Bench& b) { b.send_to_autopilot("double_acks 1000"); },
          .flies_on = true},
    Fault{.name = "answers of another session",
          .strike = [](Bench& b) { b.to_client.plan.strange_answers = true; },
          .flies_on = true},
};

constexpr std::array kPortFaults{
    Fault{.name = "unplugged for 0.4 s",
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute,
          .heals_after_s = 0.4,
          .heal = [](Bench& b) { b.cable().plug_in(End::kClient); }},
    Fault{.name = "unplugged for 3 s",
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute,
          .heals_after_s = 3.0,
          .heal = [](Bench& b) { b.cable().plug_in(End::kClient); }},
    Fault{.name = "unplugged for good",
          .strike = [](Bench& b) { b.cable().unplug(End::kClient); },
          .reach = FaultReach::kMute},
    Fault{.name = "another autopilot plugged in",
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

std::span<const Fault> authority_faults() {
  static constexpr std::array kAll = of_group(Group::kAuthority, kFaults);
  return kAll;
}
std::span<const Fault> port_faults() {
  static constexpr std::array kAll = of_group(Group::kPort, kPortFaults);
  return kAll;
}

}  // namespace m100::authority
