// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <limits>
#include <memory>
#include <optional>

#include "host_tests/scenario/authority/catalogue.h"

namespace m100::authority {
namespace {

using std::chrono::milliseconds;

constexpr std::uint8_t kWithPose = bit(Stage::kStarting) | bit(Stage::kAsking) | bit(Stage::kFlying);

template <typename Change>
void change_poses(Bench& bench, const Change& change) {
  bench.pose_messages.set_change([change](mavlink::AttPosMocap& message, core::TimePoint) {
    change(message);
    return true;
  });
}

void turn_pose(mavlink::AttPosMocap& message) {
  message.x = -message.x;
  message.y = -message.y;
  const std::array<float, 4> q = message.q;
  message.q = {-q[3], -q[2], q[1], q[0]};  // multiplied from the left by half a turn about z
}

void lose_y(mavlink::AttPosMocap& message) { message.y = std::numeric_limits<float>::quiet_NaN(); }

void freeze_pose(Bench& bench) {
  auto frozen = std::make_shared<std::optional<mavlink::AttPosMocap>>();
  change_poses(bench, [frozen](mavlink::AttPosMocap& message) {
    if (!*frozen) {
      *frozen = message;
    }
    message.x = (*frozen)->x;
    message.y = (*frozen)->y;
    message.z = (*frozen)->z;
    message.q = (*frozen)->q;
  });
}

/// Passes only every third pose.
void slow_down(Bench& bench) {
  auto count = std::make_shared<int>(0);
  bench.pose_messages.set_change([count](mavlink::AttPosMocap&, core::TimePoint) { return ++*count % 3 == 0; });
}

constexpr std::array kFaults{
    Fault{.name = "pose lost",
          .strike = [](Bench& b) { b.poses.plan.cut = true; },
          .stages = kWithPose,
          .within_s = kFailsafe_s},
    Fault{.name = "pose lost for 0.3 s",
          .strike = [](Bench& b) { b.poses.plan.cut = true; },
          .stages = kWithPose,
          .heals_after_s = 0.3,
          .heal = [](Bench& b) { b.poses.plan.cut = false; }},
    Fault{.name = "pose lost, --once",  // a script must not wait for ever: it ends after 20 s without a pose
          .strike = [](Bench& b) { b.poses.plan.cut = true; },
          .stages = bit(Stage::kStarting),
          .heals_after_s = 18.0,  // the case is watched for 5 s more
          .heal = [](Bench&) {},
          .prepare = [](Setup& s) { s.more_words.emplace_back("--once"); },
          .ends_alone = true},
    Fault{.name = "pose port unplugged",
          .strike = [](Bench& b) { b.cable().unplug(End::kClientPose); },
          .stages = kWithPose,
          .within_s = kFailsafe_s},
    Fault{.name = "pose frozen", .strike = freeze_pose, .stages = kWithPose},
    Fault{.name = "pose jumps 1 m",
          .strike = [](Bench& b) { change_poses(b, [](mavlink::AttPosMocap& message) { message.x += 1.0F; }); },
          .stages = bit(Stage::kFlying),
          .within_s = kFailsafe_s},
    Fault{.name = "pose turned by half a turn",
          .strike = [](Bench& b) { change_poses(b, turn_pose); },
          .stages = bit(Stage::kFlying),
          .within_s = kFailsafe_s},
    Fault{.name = "pose not a number",
          .strike = [](Bench& b) { change_poses(b, lose_y); },
          .stages = kWithPose,
          .within_s = kFailsafe_s},
    Fault{.name = "pose 0.4 s late",
          .strike = [](Bench& b) { b.poses.plan.delay = milliseconds(400); },  // the stamps show the capture time
          .stages = kWithPose,
          .within_s = kFailsafe_s},
    Fault{.name = "pose scrambled",
          .strike = [](Bench& b) { b.poses.plan.flip_per_bit = 0.03; },
          .stages = kWithPose,
          .within_s = kFailsafe_s},
    // A source that becomes worse: the flight must continue as with a source that was so from the start.
    Fault{.name = "pose slows to 33 Hz", .strike = slow_down, .stages = bit(Stage::kFlying), .flies_on = true},
    Fault{.name = "pose in bunches of 50 ms",
          .strike = [](Bench& b) { b.poses.plan.bunch = milliseconds(50); },
          .stages = bit(Stage::kFlying),
          .flies_on = true},
    Fault{.name = "pose in bunches of 80 ms",
          .strike = [](Bench& b) { b.poses.plan.bunch = milliseconds(80); },
          .stages = bit(Stage::kFlying),
          .flies_on = true},
    Fault{.name = "pose later by 100 to 140 ms",
          .strike =
              [](Bench& b) {
                b.poses.plan.delay = milliseconds(100);
                b.poses.plan.jitter = milliseconds(40);
              },
          .stages = bit(Stage::kFlying),
          .flies_on = true},
};

}  // namespace

std::span<const Fault> pose_faults() {
  static constexpr std::array kAll = of_group(Group::kPose, kFaults);
  return kAll;
}

}  // namespace m100::authority
