// SPDX-License-Identifier: BSD-3-Clause
// Each limit of the supervisor at its last good and first bad value, its counters, and the defaults at the start of a
// flight. The numbers are those of PROMISES.md, written out.
#include <gtest/gtest.h>

#include <string>

#include "host_tests/unit/safety/supervised_flight.h"

namespace m100::safety {
namespace {

using core::Duration;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using Flight = SupervisedFlight;

constexpr Duration kMin = microseconds(1);

/// An observation at a limit of normal flight, which the failsafe accepts and which ends normal flight one step beyond.
struct Edge {
  const char* name;
  void (*at)(Observation& seen, Duration beyond);
  FailsafeState to;
  FailsafeReason why;
};
const Edge kEdges[] = {
    {"PoseOf60Ms", [](Observation& o, Duration d) { o.estimate.pose_age = milliseconds(60) + d; },
     FailsafeState::kCoast, FailsafeReason::kPoseOld},
    {"TelemetryOf100Ms", [](Observation& o, Duration d) { o.link.telemetry_age = milliseconds(100) + d; },
     FailsafeState::kCoast, FailsafeReason::kTelemetryOld},
    {"GateShutFor300Ms", [](Observation& o, Duration d) { o.consistency.refused_for = milliseconds(300) + d - kMin; },
     FailsafeState::kLevel, FailsafeReason::kPoseRefused},
    {"VibrationThatHidesTheSpeedOfAHandOver",
     [](Observation& o, Duration d) {
       o.consistency.vibration.velocity_sigma_m_s = 0.9 + 1e-9 * static_cast<double>((d - kMin).count());
     },
     FailsafeState::kLevel, FailsafeReason::kVibration},
    {"PlaceLostFor3S", [](Observation& o, Duration d) { o.wind.exceeded_for = milliseconds(3000) + d - kMin; },
     FailsafeState::kLevel, FailsafeReason::kAuthorityExceeded},
    {"OnTheFence", [](Observation& o, Duration d) { o.fence.outside_m = 1e-9 * static_cast<double>(d.count()); },
     FailsafeState::kLevel, FailsafeReason::kFenceLeft},
    {"OnTheGroundFor500Ms", [](Observation& o, Duration d) { o.flight.on_ground_for = milliseconds(500) + d - kMin; },
     FailsafeState::kSilent, FailsafeReason::kOnGround},
    {"Unhealthy", [](Observation& o, Duration d) { o.estimate.healthy = d == Duration{0}; }, FailsafeState::kLevel,
     FailsafeReason::kEstimateLost},
    {"OutOfControl",
     [](Observation& o, Duration d) {
       o.flight.failure = d > Duration{0} ? FlightFailure::kTilt : FlightFailure::kNone;
     },
     FailsafeState::kSilent, FailsafeReason::kFlightFailure},
};

class FlightLimit : public ::testing::TestWithParam<Edge> {};

TEST_P(FlightLimit, IsBorneAndNotPassed) {
  const Edge& edge = GetParam();
  Flight borne;
  Observation seen = good(borne.now);
  edge.at(seen, Duration{0});
  EXPECT_EQ(borne.tick(seen).failsafe_state, FailsafeState::kNominal);
  Flight passed;
  seen = good(passed.now);
  edge.at(seen, kMin);
  EXPECT_EQ(passed.tick(seen).failsafe_state, edge.to);
  EXPECT_EQ(passed.supervisor.last_step().reason, edge.why);
  EXPECT_EQ(passed.supervisor.descent().reason, edge.why);
  EXPECT_EQ(passed.supervisor.last_step().from, FailsafeState::kNominal);
  EXPECT_EQ(passed.supervisor.last_step().seen.now, passed.now);
}
INSTANTIATE_TEST_SUITE_P(Safety, FlightLimit, ::testing::ValuesIn(kEdges),
                         [](const auto& tested) { return std::string(tested.param.name); });

// Catches control that is ours and silent: the release must be sent in the tick of the step, from whatever state.
TEST(FlightLimit, TheGroundAndAFailureGiveControlBackAtOnce) {
  RecordProperty("promise", "R18");
  for (const bool ground : {true, false}) {
    Flight flight;
    Observation seen = good(flight.now);
    seen.consistency.refused_for = milliseconds(300);  // halves the time on the ground
    seen.flight.on_ground_for = milliseconds(250) - kMin;
    EXPECT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kLevel);
    seen.flight.on_ground_for = ground ? milliseconds(250) : milliseconds(0);
    seen.flight.failure = ground ? FlightFailure::kNone : FlightFailure::kCrash;
    const SupervisedCommand<double> command = flight.tick(seen);
    EXPECT_TRUE(command.release);
    EXPECT_FALSE(command.transmit);
    EXPECT_FALSE(flight.tick(seen).release) << "once";
    seen.orders.engages = true;
    for (int tick = 0; tick < 20; ++tick) {
      EXPECT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kSilent) << "no start in this state";
    }
  }
}

TEST(FlightLimit, TelemetryIsDeadBehind500Ms) {
  Flight flight;
  Observation seen = good(flight.now);
  seen.link.telemetry_age = milliseconds(500);
  EXPECT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kCoast);
  seen.link.telemetry_age += kMin;
  EXPECT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kRelease);
}

// Each state ends with the tick in which its time is over, not with the one before.
TEST(FlightLimit, StatesLastAsLongAsTheySay) {
  RecordProperty("promise", "R3");
  Observation old = good({});
  old.estimate.pose_age = milliseconds(61);
  for (const Duration more : {Duration{0}, kMin}) {
    Flight flight;
    ASSERT_EQ(flight.tick(old).failsafe_state, FailsafeState::kCoast);
    EXPECT_EQ(flight.later(milliseconds(700) - kMin + more, old),
              more == kMin ? FailsafeState::kLevel : FailsafeState::kCoast);
    if (more == kMin) {
      EXPECT_EQ(flight.supervisor.last_step().reason, FailsafeReason::kCoastOver);
      EXPECT_EQ(flight.supervisor.descent().reason, FailsafeReason::kPoseOld);
      Flight longer = flight;
      EXPECT_EQ(flight.later(milliseconds(1000) - kMin, old), FailsafeState::kLevel);
      EXPECT_EQ(longer.later(milliseconds(1000), old), FailsafeState::kRelease);
      EXPECT_EQ(longer.later(milliseconds(500) - kMin, old), FailsafeState::kRelease);
      EXPECT_EQ(longer.later(kMin, old), FailsafeState::kSilent);
    }
  }
}

// The pilot gets an aircraft that is slower than 0.9 m/s, or any when the time is up: 2.5 s without poses, 10 s with
// poses. Without poses the true speed may exceed the estimate by 0.2 m/s^2 since the last pose.
TEST(FlightLimit, AMovingAircraftIsHandedOverInTheEnd) {
  RecordProperty("promise", "R12");
  for (const bool sees : {false, true}) {
    Flight flight;
    Observation seen = good({});
    seen.fence.outside_m = 1.0;
    seen.estimate.pose_age = sees ? milliseconds(20) : milliseconds(61);
    seen.consistency.speed_m_s = 0.9;
    ASSERT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kLevel);
    Flight slow = flight;
    const Duration most = sees ? milliseconds(10000) : milliseconds(2500);
    EXPECT_EQ(flight.later(most - kMin, seen), FailsafeState::kLevel);
    EXPECT_EQ(flight.later(kMin, seen), FailsafeState::kRelease);
    seen.consistency.speed_m_s = sees ? 0.8999 : 0.9 - 0.2 * 0.061 - 1e-6;
    seen.consistency.speed_then_m_s = 0.9;  // a wind beyond the tilt limit: half a second later it would be that fast
    EXPECT_EQ(slow.later(milliseconds(1000), seen), FailsafeState::kLevel);
    seen.consistency.speed_then_m_s = 0.8;
    EXPECT_EQ(slow.tick(seen).failsafe_state, FailsafeState::kRelease);
  }
}

TEST(FlightLimit, TheTimeOfLevelBeginsAfterTheTask) {
  Flight flight;
  Observation seen = good({});
  seen.fence.outside_m = 1.0;
  ASSERT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kLevel);
  seen.orders.task_flies = true;
  EXPECT_EQ(flight.later(milliseconds(20000), seen), FailsafeState::kLevel);
  seen.orders.task_flies = false;
  EXPECT_EQ(flight.later(milliseconds(1000) - kMin, seen), FailsafeState::kLevel);
  EXPECT_EQ(flight.later(kMin, seen), FailsafeState::kRelease);
}

// Catches a handover at 1.1 m/s that was predicted as 0.85: the predicted speed becomes less certain with every second
// without a pose.
TEST(FlightLimit, ASpeedThatNobodySeesIsTrustedLessTheLongerItIs) {
  Flight flight;
  Observation old = good({});
  old.fence.outside_m = 1.0;
  old.estimate.pose_age = milliseconds(61);
  old.consistency.speed_m_s = 0.61;
  ASSERT_EQ(flight.tick(old).failsafe_state, FailsafeState::kLevel);
  Flight slower = flight;
  old.estimate.pose_age = milliseconds(1500);
  EXPECT_EQ(flight.later(milliseconds(1000), old), FailsafeState::kLevel);
  old.consistency.speed_m_s = 0.59;
  EXPECT_EQ(slower.later(milliseconds(1000), old), FailsafeState::kRelease);
}

// Once a step flown through half a second without a pose ended with the pilot, although poses came back. Braking begins
// where the error exceeds the reserve, as in kLevel, and its time counts as time of kLevel.
TEST(FlightLimit, CoastBrakesWhereItsErrorExceedsTheReserveAndEndsHalfASecondAfterItBegan) {
  constexpr ctl::Command<double> kLaw{.roll_rad = 0.1}, kBrakeAndHold{.roll_rad = -0.1};
  Flight flight;
  Observation old = good({});
  old.estimate.pose_age = milliseconds(61);
  old.estimate.error_m = old.fence.reserve_m = 2.0;
  ASSERT_EQ(flight.tick(old, kLaw, kBrakeAndHold).failsafe_state, FailsafeState::kCoast);
  EXPECT_EQ(flight.tick(old, kLaw, kBrakeAndHold).command.roll_rad, 0.1);
  old.estimate.error_m = 2.0001;
  EXPECT_EQ(flight.tick(old, kLaw, kBrakeAndHold).command.roll_rad, -0.1);
  old.fence.reserve_m = 3.0;  // slow: the stopping distance is short again, but without a pose the law must not resume
  EXPECT_EQ(flight.tick(old, kLaw, kBrakeAndHold).command.roll_rad, -0.1);
  Flight seeing = flight;
  EXPECT_EQ(flight.later(milliseconds(470) - kMin, old), FailsafeState::kCoast);
  EXPECT_EQ(flight.later(kMin, old), FailsafeState::kLevel);
  EXPECT_EQ(flight.later(milliseconds(520) - kMin, old), FailsafeState::kLevel);
  EXPECT_EQ(flight.later(kMin, old), FailsafeState::kRelease) << "a second after the braking began";
  EXPECT_EQ(seeing.tick(good({}), kLaw, kBrakeAndHold).command.roll_rad, 0.1) << "the place is known again";
}

// Poses between two gaps restart the time of COAST only if they remove the effect of the first gap: they are accepted,
// and the estimated error is no larger than when COAST began.
TEST(FlightLimit, TwoGapsAreTwoCoastsOnceThePlaceIsKnownAgain) {
  struct Case {
    double error_m;
    std::uint32_t refused;
    bool renews;
  };
  for (const Case& one : {Case{0.05, 0, true}, Case{0.0501, 0, false}, Case{0.05, 1, false}}) {
    Flight flight;
    Observation old = good({});
    old.estimate.pose_age = milliseconds(61);
    old.estimate.error_m = 0.05;
    ASSERT_EQ(flight.tick(old).failsafe_state, FailsafeState::kCoast);
    old.estimate.error_m = 0.3;
    ASSERT_EQ(flight.later(milliseconds(500), old), FailsafeState::kCoast);
    Observation seen = good({});
    seen.estimate.error_m = one.error_m;
    seen.consistency.refused_poses = one.refused;
    ASSERT_EQ(flight.later(milliseconds(10), seen), FailsafeState::kCoast);
    Flight longer = flight;
    EXPECT_EQ(flight.later(milliseconds(190), old), one.renews ? FailsafeState::kCoast : FailsafeState::kLevel)
        << one.error_m;
    if (one.renews) {
      EXPECT_EQ(longer.later(milliseconds(700) - kMin, old), FailsafeState::kCoast);
      EXPECT_EQ(longer.later(kMin, old), FailsafeState::kLevel);
    }
  }
}

// The first descent is kept while the failsafe goes further down; each reported fact has its own bit of the log.
TEST(FlightLimit, TellsTheCauseOfTheDescentAndEachFact) {
  Flight lost;
  Observation old = good({});
  old.estimate.pose_age = milliseconds(61);
  ASSERT_EQ(lost.tick(old).failsafe_state, FailsafeState::kCoast);
  old.estimate.healthy = false;
  ASSERT_EQ(lost.tick(old).failsafe_state, FailsafeState::kLevel);
  EXPECT_EQ(lost.supervisor.descent().reason, FailsafeReason::kEstimateLost);
  EXPECT_EQ(lost.later(milliseconds(1000), old), FailsafeState::kRelease);
  EXPECT_EQ(lost.supervisor.descent().reason, FailsafeReason::kEstimateLost);
  for (std::size_t fact = 0; fact < 6; ++fact) {
    Flight flight;
    Observation seen = good({});
    bool& is_set = fact < 4    ? seen.model.mismatch[fact]
                   : fact == 4 ? seen.model.trim_drifted
                               : seen.limit_cycle.detected;
    is_set = true;
    const auto before = static_cast<std::uint32_t>(flight.supervisor.conditions());
    EXPECT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kNominal);
    EXPECT_EQ(static_cast<std::uint32_t>(flight.supervisor.conditions()) ^ before, 1U << (fact < 5 ? 11 + fact : 20));
  }
}

// No law of ours commands more than twice the envelope.
TEST(FlightLimit, ACommandBeyondTwiceItsRangeIsUnsound) {
  struct Case {
    double ctl::Command<double>::*member;
    double range;
  };
  for (const Case& one :
       {Case{&ctl::Command<double>::roll_rad, 0.5235987755982988},
        Case{&ctl::Command<double>::pitch_rad, 0.5235987755982988}, Case{&ctl::Command<double>::climb_m_s, 2.0},
        Case{&ctl::Command<double>::yaw_rate_rad_s, 1.7453292519943295}}) {
    for (const double sign : {1.0, -1.0}) {
      Flight flight;
      ctl::Command<double> wanted;
      wanted.*one.member = sign * 2.0 * one.range;
      EXPECT_EQ(flight.tick(good({}), wanted).failsafe_state, FailsafeState::kNominal);
      wanted.*one.member = sign * 2.0001 * one.range;
      EXPECT_EQ(flight.tick(good({}), wanted).failsafe_state, FailsafeState::kLevel);
      EXPECT_EQ(flight.supervisor.stats().invalid_commands, 1U);
    }
  }
}

// Slew and range of each command, from rest: 20 rad/s, 40 m/s^2, 40 rad/s^2 for 10 ms.
TEST(Envelope, EachCommandRisesAtItsOwnPaceToItsOwnRange) {
  RecordProperty("promise", "R5");
  Flight flight;
  const ctl::Command<double> wanted{.roll_rad = 0.3, .pitch_rad = -0.3, .climb_m_s = 3.0, .yaw_rate_rad_s = -3.0};
  ctl::Command<double> first = flight.tick(good({}), wanted).command;
  EXPECT_NEAR(first.roll_rad, 0.2, 1e-12);
  EXPECT_NEAR(first.pitch_rad, -0.2, 1e-12);
  EXPECT_NEAR(first.climb_m_s, 0.4, 1e-12);
  EXPECT_NEAR(first.yaw_rate_rad_s, -0.4, 1e-12);
  EXPECT_EQ(flight.supervisor.stats().limited_commands, 4U);
  for (int i = 0; i < 10; ++i) {
    first = flight.tick(good({}), wanted).command;
  }
  EXPECT_NEAR(first.roll_rad, 0.3, 1e-12);
  EXPECT_NEAR(first.climb_m_s, 2.0, 1e-12);
  EXPECT_NEAR(first.yaw_rate_rad_s, -1.7453292519943295, 1e-12);
  const std::uint32_t limited = flight.supervisor.stats().limited_commands;
  flight.tick(good({}), {.roll_rad = 0.3, .pitch_rad = -0.3, .climb_m_s = 2.0, .yaw_rate_rad_s = -1.7});
  EXPECT_EQ(flight.supervisor.stats().limited_commands, limited) << "nothing was cut";
}

// A command that could not leave leaves its time to the next one, once.
TEST(Envelope, TheSlewLimitCoversTheTimeThatACommandWasHeld) {
  Flight flight;
  const ctl::Command<double> climb{.climb_m_s = 2.0};
  EXPECT_EQ(flight.supervisor.hold_command(CommandSource::kLaw, milliseconds(10)).command.climb_m_s, 0.0);
  EXPECT_NEAR(flight.supervisor.limit_command(CommandSource::kLaw, climb, milliseconds(10)).command.climb_m_s, 0.8,
              1e-12);
  EXPECT_NEAR(flight.supervisor.limit_command(CommandSource::kLaw, climb, milliseconds(10)).command.climb_m_s, 1.2,
              1e-12);
}

TEST(SupervisorStats, CountTheFailsafesSteps) {
  Supervisor<double> fresh{Limits{}, Envelope{}};
  EXPECT_EQ(fresh.failsafe_state(), FailsafeState::kSilent);
  EXPECT_EQ(fresh.stats().steps + fresh.stats().invalid_commands + fresh.stats().limited_commands +
                fresh.stats().coasts + fresh.stats().levels + fresh.stats().releases,
            0U);
  Flight flight;
  EXPECT_EQ(flight.supervisor.stats().steps, 1U);
  Observation old = good({});
  old.estimate.pose_age = milliseconds(61);
  flight.tick(old);
  flight.later(milliseconds(700), old);
  flight.later(milliseconds(1000), old);
  const SupervisedCommand<double> last = [&] {
    flight.now += milliseconds(490);
    return flight.tick(old);
  }();
  EXPECT_TRUE(last.release);
  EXPECT_FALSE(last.transmit);
  EXPECT_EQ(flight.supervisor.stats().steps, 5U);
  EXPECT_EQ(flight.supervisor.stats().coasts, 1U);
  EXPECT_EQ(flight.supervisor.stats().levels, 1U);
  EXPECT_EQ(flight.supervisor.stats().releases, 1U);
  EXPECT_EQ(flight.supervisor.stats().invalid_commands, 0U);
}

// A pose whose estimated time of capture moves by less than a millisecond is the same pose.
TEST(Recovery, CountsAPoseOnlyWhereItsCaptureHasMovedByAMillisecond) {
  for (const Duration moved : {microseconds(999), microseconds(1000)}) {
    Flight flight;
    Observation seen = good({});
    seen.estimate.pose_age = milliseconds(61);
    ASSERT_EQ(flight.tick(seen).failsafe_state, FailsafeState::kCoast);
    seen.estimate.pose_age = milliseconds(10);
    for (int pose = 0; pose < 10; ++pose) {
      flight.later(moved, seen);
    }
    EXPECT_EQ(flight.supervisor.failsafe_state(),
              moved == microseconds(1000) ? FailsafeState::kNominal : FailsafeState::kCoast)
        << moved.count();
  }
}

// A fresh observation forbids flying and holds no order.
TEST(Observation, AFreshOneLetsNobodyFly) {
  const Observation fresh;
  EXPECT_EQ(fresh.estimate.pose_age, core::Duration::max());
  EXPECT_EQ(fresh.link.telemetry_age, core::Duration::max());
  EXPECT_FALSE(fresh.estimate.healthy || fresh.link.in_control || fresh.link.mode_f || fresh.orders.engages);
  EXPECT_FALSE(fresh.orders.releases || fresh.orders.task_flies || fresh.limit_cycle.detected ||
               fresh.limit_cycle.persists || fresh.model.trim_drifted);
  EXPECT_EQ(fresh.model.mismatch, (std::array<bool, 4>{}));
  EXPECT_EQ(fresh.consistency.refused_poses + fresh.consistency.contradicted_by, 0U);
  EXPECT_EQ(fresh.consistency.refused_for + fresh.wind.exceeded_for + fresh.flight.on_ground_for, core::Duration{0});
  EXPECT_EQ(fresh.flight.failure, FlightFailure::kNone);
  for (const double value :
       {fresh.consistency.refused_by_m, fresh.consistency.refused_allowed_m, fresh.estimate.error_m,
        fresh.consistency.speed_m_s, fresh.consistency.speed_then_m_s, fresh.wind.disturbance_acceleration_m_s2,
        fresh.limit_cycle.height_rad, fresh.limit_cycle.frequency_hz, fresh.consistency.refused_turn_rad,
        fresh.consistency.contradicted_with, fresh.consistency.contradicted_allowed}) {
    EXPECT_EQ(value, 0.0);
  }
}

}  // namespace
}  // namespace m100::safety
