// SPDX-License-Identifier: BSD-3-Clause
// Texts for the operator: which obstacle is named first, and that a text states the numbers behind it.
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/operator/denial.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "firmware/companion/operator/clock_step_recorder.h"
#include "firmware/companion/operator/refusal_causes.h"
#include "firmware/est/consistency/velocity_consistency.h"

namespace m100::companion {
namespace {

using safety::FailsafeReason;
using safety::Observation;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr safety::Limits kLimits;

Observation ready() {
  Observation seen;
  seen.estimate.pose_age = milliseconds(20);
  seen.link.telemetry_age = milliseconds(10);
  seen.estimate.healthy = true;
  seen.fence.outside_m = -1.0;
  return seen;
}

std::string said(FailsafeReason cause, const Observation& seen) {
  return std::string(describe(cause, seen, kLimits).text());
}

// Each quantity at its limit and one step beyond it.
TEST(Obstacle, IsWhatStandsInTheWayNow) {
  Observation seen = ready();
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kNone);
  seen.link.telemetry_age = kLimits.telemetry_stale;
  seen.estimate.pose_age = kLimits.pose_fresh;
  seen.consistency.refused_for = kLimits.gate_shut - core::Duration(1);
  seen.fence.outside_m = 0.0;
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kNone);

  seen.fence.outside_m = 0.01;
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kFenceLeft);
  seen = ready();
  seen.estimate.healthy = false;
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kEstimateLost);
  seen = ready();
  seen.estimate.pose_age = kLimits.pose_fresh + core::Duration(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseOld);
  seen = ready();
  seen.consistency.refused_for = kLimits.gate_shut;
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseRefused);
  seen = ready();
  seen.link.telemetry_age = kLimits.telemetry_stale + core::Duration(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kTelemetryOld);
}

// The root cause is named first, because removing it removes the others. Poses that an unhealthy estimate refuses are
// not an obstacle of their own.
TEST(Obstacle, TheCauseOfTheOthersIsNamedFirst) {
  Observation seen = ready();
  seen.fence.outside_m = 1.0;
  seen.estimate.pose_age = seconds(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseOld);
  seen.consistency.refused_for = seconds(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseRefused);
  seen.estimate.healthy = false;
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseOld);
  seen.link.telemetry_age = seconds(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kTelemetryOld);
}

TEST(Obstacle, APoseOfALateSourceIsFreshForLonger) {
  Observation seen = ready();
  seen.pose_latency = {.min_latency = milliseconds(60), .jitter = milliseconds(10), .interval = milliseconds(20)};
  seen.estimate.pose_age = milliseconds(110);  // 60 + 2 * 10 + 20 + 10
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kNone);
  seen.estimate.pose_age += core::Duration(1);
  EXPECT_EQ(denial_reason(seen, kLimits), FailsafeReason::kPoseOld);
}

TEST(Obstacle, WhatHelpsIsSaid) {
  EXPECT_EQ(remedy_for(FailsafeReason::kFenceLeft), "bring the aircraft inside, or take a larger fence");
  EXPECT_EQ(remedy_for(FailsafeReason::kTelemetryOld), "check the cable and the autopilot's telemetry");
  EXPECT_EQ(remedy_for(FailsafeReason::kTelemetrySilent), remedy_for(FailsafeReason::kTelemetryOld));
  EXPECT_EQ(remedy_for(FailsafeReason::kPoseOld), "check the source of pose");
  EXPECT_EQ(remedy_for(FailsafeReason::kEstimateLost), remedy_for(FailsafeReason::kPoseRefused));
  EXPECT_EQ(remedy_for(FailsafeReason::kPoseRefused), "check the likeliest cause first");
}

TEST(FlyWords, ARefusalTellsByHowMuchAndByWhom) {
  Observation seen = ready();
  seen.consistency.refused_by_m = 0.314;
  seen.consistency.refused_allowed_m = 0.021;
  const std::string apart = "pose refused: 0.314 m from the prediction, allowed 0.021 m";
  const std::string place =
      "the place of the poses (look at the source's body, axes and scale: m100 doctor --frames), or the age of "
      "the poses";
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen), apart + "; likeliest: " + place);
  seen.consistency.lever_b_m = {0.21, -0.04, 0.0};
  const std::string by_lever = said(FailsafeReason::kPoseRefused, seen);
  EXPECT_NE(by_lever.find("set offset_m = [0.21, -0.04, 0.00] in [pose] of the flight file; otherwise: " + place),
            std::string::npos);
  seen.consistency.lever_b_m = {};
  seen.consistency.refused_turn_rad = 0.35;
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen), apart + "; likeliest: " + place);
  seen.consistency.refused_turn_rad = 0.5;
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen),
            "pose refused: turned by 0.50 rad from the prediction, allowed 0.35 rad; likeliest: the heading of the "
            "poses (look whether the source lost or flipped the body's axes)");
  seen.consistency.refused_poses = 3;
  EXPECT_EQ(said(FailsafeReason::kPoseOld, seen), said(FailsafeReason::kPoseRefused, seen)) << "they come, refused";
  seen.consistency.contradicted_by = static_cast<std::uint8_t>(est::ConsistencyCheck::kAnswer);
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen).find("attitude refused: it does not follow our commands"), 0U);
  seen.consistency.contradicted_by = static_cast<std::uint8_t>(est::ConsistencyCheck::kRates);
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen).find("attitude refused: the autopilot's rates contradict it"), 0U);
  seen.consistency.contradicted_by = static_cast<std::uint8_t>(est::ConsistencyCheck::kForce);
  EXPECT_EQ(said(FailsafeReason::kPoseRefused, seen).find("pose refused: the autopilot contradicts it"), 0U);
}

// Catches a cause that does not show itself so: a compass behind a pose that turned, a pose behind a false attitude.
TEST(FlyWords, WhatWasSeenExcludesCauses) {
  using enum RefusalCause;
  const auto left_by = [](est::ConsistencyCheck check, double lever_m = 0.0) {
    Observation seen = ready();
    seen.consistency.contradicted_by = static_cast<std::uint8_t>(check);
    seen.consistency.lever_b_m = {lever_m, 0.0, 0.0};
    const RefusalCauses causes(FailsafeReason::kPoseRefused, seen);
    return std::vector(causes.list().begin(), causes.list().end());
  };
  EXPECT_EQ(left_by(est::ConsistencyCheck::kMotion), (std::vector{kPlace, kHeading, kAge, kForce, kAttitude}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kForce, 0.2), (std::vector{kLeverArm, kPlace, kAge, kForce, kAttitude}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kClimb), (std::vector{kClimb, kPlace}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kHeight), (std::vector{kClimb, kPlace}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kHeading), (std::vector{kHeading, kCompass}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kRates), std::vector{kAttitude});
  EXPECT_EQ(left_by(est::ConsistencyCheck::kAnswer), (std::vector{kAttitude, kAnswer}));
  EXPECT_EQ(left_by(est::ConsistencyCheck::kNone), (std::vector{kPlace, kAge}));
  EXPECT_TRUE(RefusalCauses(FailsafeReason::kControlGone, ready()).list().empty());
}

TEST(FlyWords, AnAgeStandsBesideItsLimit) {
  Observation seen = ready();
  seen.link.telemetry_age = milliseconds(640);
  seen.estimate.pose_age = milliseconds(75);
  EXPECT_EQ(said(FailsafeReason::kTelemetryOld, seen), "telemetry old: 0.640 s, allowed 0.100 s");
  EXPECT_EQ(said(FailsafeReason::kTelemetrySilent, seen), "telemetry silent: 0.640 s, allowed 0.500 s");
  EXPECT_EQ(said(FailsafeReason::kPoseOld, seen), "pose old: 0.075 s, allowed 0.060 s");
  seen.estimate.pose_age = core::Duration::max();
  EXPECT_EQ(said(FailsafeReason::kPoseOld, seen), "pose old: none has arrived");
}

/// The first two numbers of a text that stand before a unit.
std::array<std::string, 2> numbers_of(const std::string& text) {
  std::array<std::string, 2> out;
  std::size_t at = 0;
  for (std::string& number : out) {
    at = text.find_first_of("0123456789", at);
    const std::size_t end = text.find_first_not_of("0123456789.", at);
    number = text.substr(at, end - at);
    at = end;
  }
  return out;
}

// Catches "0.01 m apart, allowed 0.01 m", for every refusal that compares two numbers and however close they are.
TEST(FlyWords, TwoComparedNumbersAreNeverPrintedAsTheSame) {
  for (const double allowed : {0.0098, 0.0123, 0.35, 0.1004, 1.0, 2.4996, 12.0}) {
    for (const double more : {1.00002, 1.0007, 1.004, 1.06, 9.0}) {
      Observation seen = ready();
      seen.consistency.refused_by_m = seen.consistency.contradicted_with = seen.estimate.error_m = more * allowed;
      seen.consistency.refused_allowed_m = seen.consistency.contradicted_allowed = seen.fence.reserve_m = allowed;
      std::vector<std::string> texts{said(FailsafeReason::kPoseRefused, seen),
                                     said(FailsafeReason::kReserveSpent, seen)};
      seen.consistency.refused_turn_rad = 0.35 * more;
      texts.push_back(said(FailsafeReason::kPoseRefused, seen));
      for (const est::ConsistencyCheck check : {est::ConsistencyCheck::kForce, est::ConsistencyCheck::kMotion,
                                                est::ConsistencyCheck::kRates, est::ConsistencyCheck::kAnswer}) {
        seen.consistency.contradicted_by = static_cast<std::uint8_t>(check);
        texts.push_back(said(FailsafeReason::kPoseRefused, seen));
      }
      seen.link.telemetry_age = kLimits.telemetry_stale + core::Duration(std::llround(1e5 * (more - 1.0)));
      seen.estimate.pose_age = kLimits.pose_fresh + core::Duration(std::llround(1e5 * (more - 1.0)));
      texts.push_back(said(FailsafeReason::kTelemetryOld, seen));
      texts.push_back(said(FailsafeReason::kPoseOld, seen));
      for (const std::string& text : texts) {
        const auto [measured, limit] = numbers_of(text);
        EXPECT_NE(measured, limit) << text;
        EXPECT_GE(limit.size() - limit.find_first_not_of("0."), 2U) << "two digits that matter: " << text;
      }
    }
  }
}

TEST(FlyWords, WhatTookControlAwayIsSaid) {
  Observation seen = ready();
  seen.link.in_control = true;
  EXPECT_EQ(said(FailsafeReason::kControlGone, seen), "the mode switch left F");
  seen.link.in_control = false;
  EXPECT_EQ(said(FailsafeReason::kControlGone, seen), "control is not ours any more");
  seen.estimate.error_m = 0.456;
  seen.fence.reserve_m = 0.4;
  EXPECT_EQ(said(FailsafeReason::kReserveSpent, seen),
            "without a pose the position error may be 0.46 m, and the fence leaves 0.40 m");
  seen.fence.outside_m = 0.27;
  EXPECT_EQ(said(FailsafeReason::kFenceLeft, seen), "the aircraft is 0.27 m outside its fence");
  seen.wind.disturbance_acceleration_m_s2 = 1.26;
  seen.wind.exceeded_for = milliseconds(3100);
  EXPECT_EQ(said(FailsafeReason::kAuthorityExceeded, seen),
            "the wind pushes with 1.3 m/s^2; the place has not been held for 3.1 s");
  seen.limit_cycle.height_rad = 0.1745329;
  seen.limit_cycle.frequency_hz = 0.84;
  EXPECT_EQ(said(FailsafeReason::kLimitCycle, seen)
                .find("the aircraft swings by itself, by 10 degrees peak to peak, 0.8 times"),
            0U);
  seen.consistency.vibration = {.rms_m_s2 = 12.04, .peak_m_s2 = 41.0, .clipped = 0.03, .velocity_sigma_m_s = 1.2};
  EXPECT_EQ(
      said(FailsafeReason::kVibration, seen)
          .find("vibration of the specific force above 15 Hz: 12.0 m/s^2 rms on an axis, peak 41.0 m/s^2, 3 % of"),
      0U);
  EXPECT_NE(said(FailsafeReason::kVibration, seen).find("It can hide a false motion of 3.6 m/s"), std::string::npos);
  seen.flight.on_ground_for = milliseconds(520);
  EXPECT_EQ(said(FailsafeReason::kOnGround, seen), "the autopilot's flight status says \"on the ground\" for 0.5 s");
  for (const auto& [failure, text] : {std::pair{safety::FlightFailure::kTilt, "the aircraft is tilted by more than 45"},
                                      std::pair{safety::FlightFailure::kTumbling, "the aircraft tumbles"},
                                      std::pair{safety::FlightFailure::kFreeFall, "the aircraft falls"},
                                      std::pair{safety::FlightFailure::kCrash, "crash: "}}) {
    seen.flight.failure = failure;
    EXPECT_EQ(said(FailsafeReason::kFlightFailure, seen).find(text), 0U) << text;
  }
}

TEST(ClockSteps, AreSaidFromHalfATickOn) {
  struct Lines final : OperatorLog {
    void write(core::TimePoint, std::string_view line) override { said += line; }
    std::string said;
  } lines;
  ClockStepRecorder recorder;
  est::PoseTimingReport<double> timing;
  core::TimePoint now{};
  for (const int by_ms : {4, -4, -6, 150}) {
    timing.set_by += milliseconds(by_ms);
    ++timing.times_set;
    recorder.update(now += seconds(1), timing, lines);
    recorder.update(now += seconds(1), timing, lines);
  }
  EXPECT_EQ(lines.said, "the source's clock was set by -0.01 sthe source's clock was set by +0.15 s");
  EXPECT_EQ(recorder.steps().size(), 2U);
}

TEST(FlyWords, NoStartWithAFailureOrOnTheGround) {
  Observation seen = ready();
  seen.flight.on_ground_for = safety::Limits{}.on_ground;
  EXPECT_EQ(denial_reason(seen, {}), FailsafeReason::kOnGround);
  seen.flight.failure = safety::FlightFailure::kTilt;
  EXPECT_EQ(denial_reason(seen, {}), FailsafeReason::kFlightFailure);
}

}  // namespace
}  // namespace m100::companion
