// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/refusal_causes.h"

#include <algorithm>
#include <chrono>

#include "firmware/est/consistency/consistency_check.h"

namespace m100::companion {
namespace {

using est::ConsistencyCheck;
using est::set_of;
using safety::FailsafeReason;

// What shows a contradiction beside the checks: the observer's gate, and what is missing.
using Signs = std::uint16_t;
constexpr Signs kJumped = 1U << 8U, kTurned = 1U << 9U, kStopped = 1U << 10U, kUnknownTilt = 1U << 11U;
constexpr Signs kLever = 1U << 12U;  ///< the difference turns with the aircraft, as a lever arm does
constexpr Signs kForce = set_of(ConsistencyCheck::kForce), kClimb = set_of(ConsistencyCheck::kClimb),
                kHeading = set_of(ConsistencyCheck::kHeading), kMotion = set_of(ConsistencyCheck::kMotion),
                kRates = set_of(ConsistencyCheck::kRates), kAnswer = set_of(ConsistencyCheck::kAnswer),
                kHeight = set_of(ConsistencyCheck::kHeight);

struct Row {
  RefusalCause cause;
  std::string_view name;
  Signs shows;  ///< by one of these the cause shows itself, and by nothing else
  Signs needs;  ///< without this it is not the cause
  std::string_view remedy;
};

// Where the same sign shows several, the likelier comes first: a false specific force or attitude falsifies the path
// with which the poses are compared, and what was seen does not tell it from false poses.
constexpr std::array<Row, kRefusalCauseCount> kRows{{
    Row{RefusalCause::kLeverArm, "a lever arm", kJumped | kForce | kMotion, kLever, ""},
    Row{RefusalCause::kClimb, "the autopilot's climb speed or height", kClimb | kHeight, 0,
        "compare the autopilot's height with the room's while a hand lifts the aircraft"},
    Row{RefusalCause::kPlace, "the place of the poses", kJumped | kStopped | kForce | kMotion | kClimb | kHeight, 0,
        "look at the source's body, axes and scale: m100 doctor --frames"},
    Row{RefusalCause::kHeading, "the heading of the poses", kTurned | kHeading | kMotion, 0,
        "look whether the source lost or flipped the body's axes"},
    Row{RefusalCause::kCompass, "the autopilot's compass", kHeading, 0, ""},
    Row{RefusalCause::kAge, "the age of the poses", kJumped | kStopped | kForce | kMotion, 0, ""},
    Row{RefusalCause::kForce, "the specific force", kForce | kMotion, 0, ""},
    Row{RefusalCause::kAttitude, "the autopilot's attitude or its rates",
        kUnknownTilt | kRates | kAnswer | kForce | kMotion, 0,
        "calibrate the autopilot's inertial sensors, and see that it is fastened"},
    Row{RefusalCause::kAnswer, "a hand, a load or a damage that keeps the aircraft from answering", kAnswer, 0, ""},
}};

constexpr const Row& row(RefusalCause cause) { return kRows[static_cast<std::size_t>(cause)]; }
static_assert(std::all_of(kRows.begin(), kRows.end(), [](const Row& one) { return &row(one.cause) == &one; }));

Signs signs_of(FailsafeReason reason, const safety::Observation& seen) {
  constexpr core::Duration kLost = std::chrono::seconds(1);  ///< without a pose the estimate ends (Estimate::healthy)
  if (poses_are_refused(reason, seen)) {
    const std::array<double, 3>& lever_b_m = seen.consistency.lever_b_m;
    const Signs lever = lever_b_m[0] != 0.0 || lever_b_m[1] != 0.0 ? kLever : Signs{0};
    const Signs by_gate = seen.consistency.refused_turn_rad > kHeadingGate_rad ? kTurned : kJumped;
    const Signs by_check = set_of(static_cast<ConsistencyCheck>(seen.consistency.contradicted_by));
    return static_cast<Signs>(lever | (by_check != 0 ? by_check : by_gate));
  }
  switch (reason) {
    case FailsafeReason::kEstimateLost:
      return seen.estimate.pose_age < kLost ? kUnknownTilt : kStopped;
    case FailsafeReason::kPoseOld:
    case FailsafeReason::kCoastOver:
    case FailsafeReason::kReserveSpent:
      return kStopped;
    default:
      return 0;
  }
}

}  // namespace

bool poses_are_refused(FailsafeReason reason, const safety::Observation& seen) {
  return reason == FailsafeReason::kPoseRefused ||
         (reason == FailsafeReason::kPoseOld && seen.consistency.refused_poses > 0);
}

RefusalCauses::RefusalCauses(safety::FailsafeReason reason, const safety::Observation& seen) {
  const Signs signs = signs_of(reason, seen);
  for (const Row& one : kRows) {
    if ((one.shows & signs) != 0 && (one.needs & signs) == one.needs) {
      causes_[count_++] = one.cause;
    }
  }
}

TextLine& add_causes(TextLine& line, const RefusalCauses& causes) {
  std::string_view before = "; likeliest: ";
  for (const RefusalCause cause : causes.list()) {
    if (cause == RefusalCause::kLeverArm) {
      before = "; otherwise: ";
      continue;
    }
    line.add(before).add(row(cause).name);
    if (before.front() == ';' && !row(cause).remedy.empty()) {
      line.add(" (").add(row(cause).remedy).add(")");
    }
    before = ", or ";
  }
  return line;
}

}  // namespace m100::companion
