// SPDX-License-Identifier: BSD-3-Clause
// The whole program against the emulated autopilot. A task of the paper has two limits: the paper's result, and our
// result as published in README.md and lab/experiments/README.md plus a stated margin. The second one shows a
// regression long before the paper's limit is reached.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "firmware/companion/replay/replay.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {
namespace {

using std::chrono::milliseconds;

/// Our results as first published, m and degrees. Today's (README.md, host_tests/lab/experiments/README.md) are worse
/// by a millimetre in hover and squares and by 7 mm in the simulator, because the command moves less; the limits were
/// not widened. The yaw of the simulator's course was not published: mean of forty seeds, 1.48 degrees (paper: 26).
struct Ours {
  const char* task;
  const char* condition;
  double pose_m, yaw_deg;
  double share;  ///< margin: 50 % for hover and squares, 10 % for steps, whose error is mostly the step
};
constexpr std::array kOurs{Ours{"hover", "calm", 0.016, 0.284, 1.5},      Ours{"hover", "wind", 0.016, 0.481, 1.5},
                           Ours{"step", "calm", 0.317, 0.288, 1.1},       Ours{"step", "wind", 0.240, 0.488, 1.1},
                           Ours{"trajectory", "calm", 0.016, 0.287, 1.5}, Ours{"trajectory", "wind", 0.016, 0.483, 1.5},
                           Ours{"simulator", "calm", 0.021, 1.48, 1.5}};

class PaperTask : public ::testing::TestWithParam<std::size_t> {};

TEST_P(PaperTask, IsFlownNoWorseThanThePaperSays) {
  RecordProperty("paper", "IV-D, Control performance summary");
  SuiteOptions options;
  options.plan.plant = sim::measured_plant();
  options.plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  options.literal_steps = false;
  const Task& task = paper_tasks()[GetParam()];
  options.only = task.task;
  for (const TaskResult& result : fly_suite(options)) {
    SCOPED_TRACE(result.task->task + " " + result.task->condition);
    ASSERT_EQ(result.refused, 0);
    const model::paper::ResultColumn& paper = *result.task->paper;
    EXPECT_LE(result.mean.pose_m, paper.pose_m);
    EXPECT_LE(result.mean.x_m, paper.x_m);
    EXPECT_LE(result.mean.y_m, paper.y_m);
    EXPECT_LE(result.mean.z_m, paper.z_m);
    EXPECT_LE(result.mean.yaw_deg, paper.yaw_deg);
    EXPECT_EQ(result.mean.off_nominal_share, 0.0);
    EXPECT_LT(result.largest_tilt_deg, 35.0);
    const auto ours = std::find_if(kOurs.begin(), kOurs.end(), [&result](const Ours& row) {
      return row.task == result.task->task && row.condition == result.task->condition;
    });
    ASSERT_NE(ours, kOurs.end());
    EXPECT_LE(result.mean.pose_m, ours->share * ours->pose_m);
    EXPECT_LE(result.mean.yaw_deg, ours->share * ours->yaw_deg);
  }
}
INSTANTIATE_TEST_SUITE_P(Table, PaperTask, ::testing::Values(0U, 2U, 4U, 6U));

FlightPlan hover(double duration_s) {
  FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.duration_s = duration_s;
  return plan;
}

/// Largest distance from the reference in a window, m.
double worst(const FlightResult& flight, double from_s, double to_s) {
  return score(flight.trace, from_s, to_s).worst_m;
}

TEST(Flight, StartsObtainsControlAndGivesItBackByTheProtocol) {
  RecordProperty("promise", "R4");
  const FlightResult flight = fly(hover(5.0));
  EXPECT_TRUE(flight.flew);
  EXPECT_TRUE(flight.handed_over);
  EXPECT_GE(flight.autopilot.min_obtain_spacing, std::chrono::seconds(2));
  EXPECT_LE(flight.autopilot.obtain_requests, 3U);
  EXPECT_LE(flight.autopilot.max_commands_per_s, 26U);
  EXPECT_EQ(flight.autopilot.control_after_loss, 0U);
}

TEST(Flight, SurvivesPoseDropoutsOfAFifthOfASecond) {
  FlightPlan plan = hover(20.0);
  plan.disturb = [](sim::World& world, double t_s) {
    const double phase = std::fmod(t_s, 4.0);
    world.pose_source().set_faults({.silent = t_s > 4.0 && phase < 0.2});
  };
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  EXPECT_LT(worst(flight, 4.0, 20.0), 0.15);  // issue: below 0.15 m, recovers by itself
  EXPECT_EQ(flight.trace.back().failsafe_state, static_cast<int>(safety::FailsafeState::kNominal));
}

struct Fault {
  const char* name;
  void (*apply)(sim::World&);
  int failsafe_state;  ///< state of the failsafe five seconds later
  double farthest_m;   ///< measured distance from the hover point while the program commands; 1 cm in a normal hover
};
constexpr double kTwiceAsFar = 2.0;  ///< common margin
class SingleFault : public ::testing::TestWithParam<Fault> {};

TEST_P(SingleFault, EndsInsideTheFenceOrWithThePilot) {
  RecordProperty("promise", "R12");
  FlightPlan plan = hover(15.0);
  bool done = false;
  plan.disturb = [&done](sim::World& world, double t_s) {
    if (t_s >= 8.0 && !done) {
      done = true;
      GetParam().apply(world);
    }
  };
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  EXPECT_LT(flight.touchdown_speed_m_s, 1.0);
  EXPECT_LT(flight.largest_tilt_deg, 35.0);
  EXPECT_LE(flight.autopilot.latest_after_loss, milliseconds(40));  // R4: one command period
  EXPECT_EQ(flight.trace.back().failsafe_state, GetParam().failsafe_state);
  double farthest = 0.0;
  for (const TracePoint& point : flight.trace) {
    if (point.t_s > 8.0 && point.failsafe_state != static_cast<int>(safety::FailsafeState::kSilent)) {
      farthest = std::max(farthest, std::hypot(point.position_m[0], point.position_m[1]));
    }
  }
  EXPECT_LT(farthest, kTwiceAsFar * GetParam().farthest_m);
}

constexpr int kSilent = static_cast<int>(safety::FailsafeState::kSilent);
constexpr int kNominal = static_cast<int>(safety::FailsafeState::kNominal);
INSTANTIATE_TEST_SUITE_P(
    Battery, SingleFault,
    ::testing::Values(
        Fault{"PoseSilent", [](sim::World& w) { w.pose_source().set_faults({.silent = true}); }, kSilent, 0.026},
        Fault{"PoseNotANumber", [](sim::World& w) { w.pose_source().set_faults({.not_finite = true}); }, kSilent,
              0.026},
        Fault{"PoseJumps",
              [](sim::World& w) {
                w.pose_source().set_faults({.jump_m = {3.0, 0.0, 0.0}});
              },
              kSilent, 0.029},
        Fault{"PoseTurned", [](sim::World& w) { w.pose_source().set_faults({.turn_rad = 3.14159}); }, kSilent, 0.511},
        Fault{"PoseLate", [](sim::World& w) { w.pose_source().set_faults({.extra_delay = milliseconds(30)}); },
              kNominal, 0.012},
        Fault{"PoseJitters", [](sim::World& w) { w.pose_source().set_faults({.jitter = milliseconds(25)}); }, kNominal,
              0.013},
        Fault{"PilotLeavesModeF", [](sim::World& w) { w.autopilot().set_mode(sim::N1Mode::kP); }, kSilent, 0.004},
        Fault{"MobileAppTakesOver", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kTake, 'm'); }, kSilent,
              0.004},
        Fault{"AutopilotRestarts", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kRestart); }, kSilent,
              0.008},
        Fault{"LinkSilent", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kSilence, 30.0); }, kSilent,
              0.008},
        Fault{"FramesLost", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kLoss, 0.1); }, kNominal, 0.011},
        Fault{"CableOut", [](sim::World& w) { w.autopilot_line().set_plugged(false); }, kSilent, 0.008},
        Fault{"Payload30PerCent", [](sim::World& w) { w.vehicle().add_payload(1.0); }, kNominal, 0.012},
        Fault{"SlowerActuators", [](sim::World& w) { w.vehicle().slow_actuators(0.8); }, kNominal, 0.011}),
    [](const auto& tested) { return tested.param.name; });

companion::RecordedFlight read_back(const FlightResult& flight) {
  return companion::parse_flight_log({flight.log.begin(), flight.log.end()}, "flight");
}

// Catches a field that is never written, an omitted axis, and a count that is not reset in each tick. Three metres from
// rest to rest in 1.4 s need up to 8.8 m/s^2, so that both limits become active, one axis after the other.
TEST(Log, CountsTheChangesOfTheActiveSetsInEachTick) {
  FlightPlan plan = hover(6.0);
  plan.keep_log = true;
  plan.course = "quintic 3 0 0 0 1.4\nstep 3 0 0 0 1.5\nquintic 3 3 0 0 1.4\n";
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  int changed_by_x = 0;
  int changed_by_y = 0;
  for (const companion::RecordedFlight::Tick& tick : read_back(flight).ticks) {
    const bool x_iterates = tick.record.mpc_path_x >= static_cast<int>(mpc::Path::kActiveSet);
    const bool y_iterates = tick.record.mpc_path_y >= static_cast<int>(mpc::Path::kActiveSet);
    if (!x_iterates && !y_iterates) {
      EXPECT_EQ(tick.record.mpc_changes, 0) << "no limit is active at " << tick.record.timestamp << " us";
    }
    changed_by_x += tick.record.mpc_changes > 0 && !y_iterates ? 1 : 0;
    changed_by_y += tick.record.mpc_changes > 0 && !x_iterates ? 1 : 0;
  }
  EXPECT_GT(changed_by_x, 0);
  EXPECT_GT(changed_by_y, 0);
}

// Catches a command with tilts of an earlier tick, and an MPC program that is solved in a tick in which no command can
// be sent.
TEST(Law, SolvesItsProgramsInTheTicksWhoseCommandLeaves) {
  FlightPlan plan = hover(4.0);
  plan.keep_log = true;
  plan.solves_when_due = true;
  plan.course = "step 0 0 0 0 1\nquintic 0.5 0.5 0 0 2\n";
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  std::array<double, 4> before{};
  int held = 0;
  int left = 0;
  int flown = 0;
  for (const companion::RecordedFlight::Tick& tick : read_back(flight).ticks) {
    const bool flies = tick.record.state == static_cast<int>(safety::FailsafeState::kNominal);
    flown = flies ? flown + 1 : 0;
    if (flown > 1) {  // pose noise changes every solution
      const bool moved = tick.record.wanted[0] != before[0] && tick.record.wanted[1] != before[1];
      EXPECT_EQ(moved, tick.record.sent == 1) << "at " << tick.record.timestamp << " us";
      EXPECT_TRUE(tick.record.sent == 0 || std::abs(tick.record.granted[0] - tick.record.wanted[0]) < 1e-12);
      held += moved ? 0 : 1;
      left += moved ? 1 : 0;
    }
    before = tick.record.wanted;
  }
  EXPECT_GT(left, 90) << "25 a second";
  EXPECT_GT(held, 280);
}

// Exactly the same sticks must leave in both modes, also after a far jump. Catches a delay line that misses ticks, an
// integrator that integrates a quarter of its time, and a slew limit that counts from a command that was never sent.
TEST(Law, FliesTheSameWhetherItsProgramsAreSolvedInEachTickOrWhereOneIsDue) {
  FlightPlan plan = hover(12.0);
  plan.course = "step 0 0 0 0 2\nquintic 0.5 0.5 0.3 0.4 3\nstep 4 0 0.3 0.4 7\n";
  const FlightResult each = fly(plan);
  plan.solves_when_due = true;
  const FlightResult due = fly(plan);
  ASSERT_TRUE(each.flew && due.flew);
  ASSERT_EQ(each.trace.size(), due.trace.size());
  for (std::size_t i = 0; i < each.trace.size(); i += 50) {
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_EQ(each.trace[i].position_m[d], due.trace[i].position_m[d]) << "at " << each.trace[i].t_s << " s";
    }
  }
}

// Catches a configuration in which the designed height gains fly, a command rate of 25 Hz, [design] in the observer, or
// identified axes in the law: the paper's climb command after a step of 0.3 m is 1.963 * 0.3 m/s and grows by the
// integral, the designed one begins above 1 m/s.
TEST(Law, FliesThePapersConfiguration) {
  RecordProperty("paper", "III-E.2");
  FlightPlan plan = hover(6.0);
  plan.course = "step 0 0 0 0 3\nstep 0 0 0.3 0 3\n";
  const auto climb_after_step = [](const FlightResult& flight) {
    double largest_m_s = 0.0;
    for (const TracePoint& point : flight.trace) {
      if (point.t_s >= 3.0 && point.t_s < 3.08) {
        largest_m_s = std::max(largest_m_s, point.applied_command[2]);
      }
    }
    return largest_m_s;
  };
  const FlightResult ours = fly(plan);
  const FlightPlan configured = in_paper_configuration(plan);
  const model::Vehicle& paper = configured.vehicle.vehicle;
  const model::Vehicle flown = model::controller_model(paper);
  EXPECT_TRUE(flown.roll.is_first_order() && flown.pitch.is_first_order()) << "not the [design] of the shipped vehicle";
  EXPECT_EQ(paper.roll.natural_frequency_rad_s, model::paper::kRollSecond.natural_frequency_rad_s) << "the observer's";
  EXPECT_FALSE(paper.roll.is_first_order());
  EXPECT_NEAR(flown.mpc.input, 0.5 * (143.28 / (1.673 * 1.673) + 145.27 / (1.575 * 1.575)), 0.05);
  EXPECT_EQ(flown.mpc.position, 28.0);
  EXPECT_EQ(paper.yaw.proportional_per_s, 1.9);
  const FlightResult papers = fly(configured);
  ASSERT_TRUE(ours.flew && papers.flew);
  EXPECT_GT(climb_after_step(ours), 1.0);
  // At most the whole integral, 0.2 m/s, and 0.2 m/s for the height that the air takes away.
  EXPECT_NEAR(climb_after_step(papers), model::paper::kAltitudeKp * 0.3, 0.4);
  const auto sticks = [](const FlightResult& flight) { return flight.autopilot.virtual_rc_taken; };
  EXPECT_GT(sticks(papers), 3 * sticks(ours));
  EXPECT_LT(score(papers.trace, 1.0, 3.0).pose_m, 0.3);
}

// The log says which law flew: without its word the replay would fly ours, and differ.
TEST(Replay, GivesAFlightOfThePapersLawAgain) {
  FlightPlan plan = in_paper_configuration(hover(3.0));
  plan.keep_log = true;
  plan.course = "step 0 0 0 0 1\nstep 0.5 0.2 0.1 0.3 2\n";
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  const companion::RecordedFlight recorded = read_back(flight);
  EXPECT_EQ(companion::replay(recorded, companion::Scalar::kDouble).different_ticks, 0U);
}

// The recorded bytes at the recorded times must give the recorded flight, bit for bit.
TEST(Replay, GivesTheSameFlightAgain) {
  RecordProperty("promise", "R6");
  FlightPlan plan = hover(3.0);
  plan.keep_log = true;
  plan.course = "step 0 0 0 0 1\nstep 0.5 0.2 0.1 0.3 2\n";
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  ASSERT_EQ(flight.dropped_log_messages, 0U);
  const companion::RecordedFlight recorded = read_back(flight);
  const companion::ReplayResult again = companion::replay(recorded, companion::Scalar::kDouble);
  EXPECT_EQ(again.ticks, recorded.ticks.size());
  EXPECT_EQ(again.different_ticks, 0U) << "first at tick " << again.first_difference;
  EXPECT_EQ(again.digest, companion::replay(recorded, companion::Scalar::kDouble).digest);
  // Other arithmetic gives the same flight within millimetres.
  EXPECT_LT(companion::replay(recorded, companion::Scalar::kFloat).largest_difference_m, 2e-3);
  EXPECT_LT(companion::replay(recorded, companion::Scalar::kFixed).largest_difference_m, 2e-3);
}

// A log of the LQR baseline with active limits: replayed with the MPC, it would be another flight.
TEST(Replay, KnowsWhichLawFlew) {
  FlightPlan plan = hover(4.0);
  plan.keep_log = true;
  plan.course = "step 0 0 0 0 1\nstep 4 3 0 0 3\n";
  plan.law = mpc::Law::kLqr;
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  companion::RecordedFlight recorded = read_back(flight);
  EXPECT_EQ(companion::replay(recorded, companion::Scalar::kDouble).different_ticks, 0U);
  std::string& note = recorded.notes.at(companion::kLinkNote);
  const std::size_t law = note.find(" law lqr");
  ASSERT_NE(law, std::string::npos);
  note.erase(law);
  EXPECT_GT(companion::replay(recorded, companion::Scalar::kDouble).different_ticks, 0U);
}

/// A damage to the recorded data of a tick.
struct Damage {
  const char* what;
  std::vector<std::byte>* (*stream)(companion::RecordedFlight::Tick&);
};
constexpr std::array kDamages{
    Damage{"autopilot's bytes", [](companion::RecordedFlight::Tick& tick) { return &tick.autopilot_in; }},
    Damage{"sent bytes", [](companion::RecordedFlight::Tick& tick) { return &tick.autopilot_out; }},
    Damage{"pose's bytes", [](companion::RecordedFlight::Tick& tick) { return &tick.pose_in; }},
    Damage{"questions for the time", [](companion::RecordedFlight::Tick& tick) { return &tick.pose_out; }}};

// Catches a field, a stream or a tick that the comparison omits: changes every byte of a record, and a bit of each
// stream in the first tick after the middle of the flight that has data in it.
TEST(Replay, NoticesEveryDamagedByteAndSaysInWhichTick) {
  RecordProperty("promise", "R6");
  FlightPlan plan = hover(1.0);
  plan.keep_log = true;
  plan.course = "step 0 0 0 0 1\n";
  const FlightResult flight = fly(plan);
  ASSERT_TRUE(flight.flew);
  const companion::RecordedFlight sound = read_back(flight);
  const std::size_t middle = sound.ticks.size() / 2;
  const auto first_difference = [](const companion::RecordedFlight& flown) {
    const companion::ReplayResult result = companion::replay(flown, companion::Scalar::kDouble);
    return result.different_ticks > 0 && result.differences.front() == result.first_difference ? result.first_difference
                                                                                               : flown.ticks.size();
  };
  ASSERT_EQ(first_difference(sound), sound.ticks.size());
  companion::RecordedFlight damaged = sound;
  for (const Damage& damage : kDamages) {
    std::size_t tick = middle;
    while (tick < sound.ticks.size() && damage.stream(damaged.ticks[tick])->empty()) {
      ++tick;
    }
    ASSERT_LT(tick, sound.ticks.size()) << damage.what;
    damage.stream(damaged.ticks[tick])->back() ^= std::byte{4};
    const std::size_t differences = first_difference(damaged);
    EXPECT_GE(differences, tick) << damage.what;
    EXPECT_LT(differences, tick + 20) << damage.what
                                      << ": a damaged frame must be noticed at the latest when the next one arrives";
    damaged = sound;
  }
  // All bytes of the record in one replay: byte i of the record of tick i.
  constexpr std::size_t kTime = sizeof(log::TickRecord::timestamp);  // the time at which the tick is replayed
  std::vector<std::size_t> spoilt;
  constexpr std::size_t kOrders = offsetof(log::TickRecord, orders);  // the replay obeys these orders
  ASSERT_LT(kOrders, sound.ticks.size());
  for (std::size_t i = kTime; i < kOrders; ++i) {
    reinterpret_cast<unsigned char*>(&damaged.ticks[i].record)[i] ^= 1U;
    spoilt.push_back(i);
  }
  EXPECT_EQ(companion::replay(damaged, companion::Scalar::kDouble).differences, spoilt);
}

}  // namespace
}  // namespace m100::lab::experiments
