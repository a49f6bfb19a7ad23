// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <random>

namespace m100::safety {
namespace {

using std::chrono::microseconds;

Observation random_observation(std::mt19937_64& random, core::TimePoint now) {
  const auto chance = [&random](double p) { return std::uniform_real_distribution<>(0.0, 1.0)(random) < p; };
  const auto age = [&random](double mean_s) {
    return microseconds(static_cast<std::int64_t>(std::exponential_distribution<>(1e-6 / mean_s)(random)));
  };
  return {.now = now,
          .estimate = {.pose_age = age(0.03), .healthy = chance(0.999)},
          .consistency = {.refused_for = chance(0.01) ? microseconds(400000) : microseconds(0)},
          .link = {.telemetry_age = chance(0.01) ? age(1.0) : age(0.02),
                   .in_control = chance(0.995),
                   .mode_f = chance(0.998)},
          .orders = {.engages = chance(0.05), .releases = chance(0.001)}};
}

double random_number(std::mt19937_64& random) {
  switch (std::uniform_int_distribution<>(0, 60)(random)) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return -std::numeric_limits<double>::infinity();
    case 2:
      return 1e30;
    default:
      return std::normal_distribution<>(0.0, 0.3)(random);
  }
}

class SupervisorObservations : public ::testing::TestWithParam<int> {};

// For any sequence of observations: no transmission without authority and mode F, no step up from level or silence
// without the operator, and every number finite and inside its range and slew limit.
TEST_P(SupervisorObservations, NeverGrantWhatTheyMustNot) {
  RecordProperty("promise", "R4,R5");
  std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()));
  SCOPED_TRACE("seed " + std::to_string(GetParam()));
  const Envelope envelope;
  Supervisor<double> supervisor(Limits{}, envelope);
  core::TimePoint now{};
  ctl::Command<double> last;
  for (int i = 0; i < 20000; ++i) {
    now += microseconds(10000);
    const Observation seen = random_observation(random, now);
    const ctl::Command<double> wanted{random_number(random), random_number(random), random_number(random),
                                      random_number(random)};
    const FailsafeState before = supervisor.failsafe_state();
    const CommandSource passes = supervisor.update_failsafe(wanted, seen);
    const SupervisedCommand<double> grant =
        supervisor.limit_command(passes, passes == CommandSource::kLaw ? wanted : ctl::Command<double>{}, 0.01);
    ASSERT_FALSE(grant.transmit && !(seen.link.in_control && seen.link.mode_f));
    ASSERT_FALSE(
        (before == FailsafeState::kSilent || before == FailsafeState::kLevel || before == FailsafeState::kRelease) &&
        grant.failsafe_state == FailsafeState::kNominal && !seen.orders.engages);
    ASSERT_FALSE(before == FailsafeState::kNominal && grant.failsafe_state == FailsafeState::kNominal &&
                 seen.estimate.pose_age > std::chrono::milliseconds(60));
    const auto check = [](double value, double was, double range, double slew) {
      ASSERT_TRUE(std::isfinite(value));
      ASSERT_LE(std::abs(value), range);
      ASSERT_LE(std::abs(value - was), slew * 0.01 + 1e-12);
    };
    check(grant.command.roll_rad, last.roll_rad, envelope.tilt_rad, envelope.tilt_slew_rad_s);
    check(grant.command.pitch_rad, last.pitch_rad, envelope.tilt_rad, envelope.tilt_slew_rad_s);
    check(grant.command.climb_m_s, last.climb_m_s, envelope.climb_m_s, envelope.climb_slew_m_s2);
    check(grant.command.yaw_rate_rad_s, last.yaw_rate_rad_s, envelope.yaw_rate_rad_s, envelope.yaw_slew_rad_s2);
    last = grant.command;
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, SupervisorObservations, ::testing::Range(1, 9));

// Every state and all 2^11 sets of signs: without permission to command, the failsafe is silent in the next tick.
TEST(FailsafeStates, LeaveEveryStateWhenAuthorityGoes) {
  for (int bits = 0; bits < (1 << 11); ++bits) {
    const FailsafeCondition conditions = static_cast<FailsafeCondition>(bits);
    for (const FailsafeState state : {FailsafeState::kSilent, FailsafeState::kNominal, FailsafeState::kCoast,
                                      FailsafeState::kLevel, FailsafeState::kRelease}) {
      if (!any(conditions, FailsafeCondition::kCommandable)) {
        ASSERT_EQ(next_failsafe_state(state, conditions), FailsafeState::kSilent) << "signs " << bits;
      }
    }
  }
}

}  // namespace
}  // namespace m100::safety
