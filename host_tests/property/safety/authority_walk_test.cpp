// SPDX-License-Identifier: BSD-3-Clause
// An exhaustive walk of the product of the authority table with an abstract autopilot, line and operator, in discrete
// time. It visits every reachable state once, and tries every possible next event there.
#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

#include "host_tests/property/safety/authority_world.h"

namespace m100::safety::walk {
namespace {

struct Choice {
  Event event = Event::kNothing;
  Operator acts = Operator::kNothing;
  bool telemetry_arrives = true;
  bool push_arrives = true;
  bool ack_arrives = true;
  bool request_arrives = true;
  bool time_passes = true;
};

class Walk {
 public:
  /// @param masked the RC item shows Virtual RC's own mode while that is on, which hides the end of mode F.
  Walk(bool uses_virtual_rc, bool masked)
      : uses_virtual_rc_(uses_virtual_rc), masked_(masked), table_(std::size_t{1} << kTableBits) {}

  void run() {
    add(World{});
    for (std::size_t i = 0; i < order_.size() && !failed(); ++i) {
      const World world = unpack(order_[i]);
      expand(world);
    }
  }

  bool failed() const { return !failure_.empty(); }
  const std::string& failure() const { return failure_; }
  const std::vector<std::uint64_t>& states() const { return order_; }
  std::uint64_t steps() const { return steps_; }
  const std::bitset<kStageCount>& stages() const { return stages_; }

  /// One step of the world. Sets failure() if the examiner finds a violation.
  World step_world(World world, const Choice& choice) {
    ++steps_;
    const core::Duration elapsed = choice.time_passes ? kUnit : core::Duration{0};
    const std::uint64_t passed = choice.time_passes ? 1 : 0;
    world.since_obtain = std::min(world.since_obtain + passed, kSpacingUnits);
    world.since_on = std::min(world.since_on + passed, kSpacingUnits);
    world.seen.silent = world.seen.silent || choice.time_passes;

    AuthorityCondition conditions = when(choice.event == Event::kPortBack, AuthorityCondition::kPortBack);
    if (happen(world.autopilot, choice.event) && choice.push_arrives) {
      conditions |= AuthorityCondition::kControlLostPush;
    }
    if (choice.telemetry_arrives) {
      // The client notices a restart by the autopilot's clock in the first telemetry after it; here in the same step.
      conditions |= when(choice.event == Event::kRestart, AuthorityCondition::kRestarted);
      world.seen = {world.autopilot.f, world.autopilot.virtual_rc, world.autopilot.device, false};
    }
    conditions |= answer_sign(world, choice);
    conditions |= operator_sign(world, choice.acts) | levels(world.seen);

    const bool was_busy = (kAcquiring | kHolding).has(world.client.stage);
    const AuthorityStep made = step(world.client, conditions, elapsed);
    world.client = made.state;
    world.open = world.open && !made.moved;
    stages_.set(static_cast<std::size_t>(world.client.stage));
    examine(world, made, choice);
    const bool silent_now =
        world.client.stage == AuthorityStage::kSilent || world.client.stage == AuthorityStage::kSilentCold;
    world.must_be_silent = world.must_be_silent || (was_busy && silent_now);
    if (choice.event == Event::kPortBack) {
      examine_port_back(world);
    }
    act(world, made.action, choice);
    canonicalise(world);
    return world;
  }

 private:
  static constexpr unsigned kTableBits = 25;

  static AuthorityCondition answer_sign(World& world, const Choice& choice) {
    AuthorityCondition sign = AuthorityCondition::kNone;
    if (world.open && world.ack != Ack::kNone && choice.ack_arrives) {
      sign = sign_of(world.ack);
      world.open = false;
    } else if (world.open && world.open_old) {
      sign = AuthorityCondition::kNoAnswer;
      world.open = false;
    }
    world.open_old = world.open && (world.open_old || choice.time_passes);
    return sign;
  }
  /// Start-up may run again. That control is requested only after an order is tested on the table itself.
  void examine_port_back(World& world) {
    world.must_be_silent = false;
    if (world.client.stage != AuthorityStage::kListening || world.client.control_requested) {
      fail("after the port came back, start-up does not restart or an earlier order still counts");
    }
  }
  AuthorityCondition operator_sign(World& world, Operator acts) const {
    if (acts == Operator::kAsks) {
      world.must_be_silent = false;
      world.obtains_since_ask = 0;
      world.ons_since_ask = 0;
      return AuthorityCondition::kControlRequested;
    }
    return acts == Operator::kReleases ? AuthorityCondition::kReleaseRequested : AuthorityCondition::kNone;
  }
  AuthorityCondition levels(const Seen& seen) const {
    return when(!seen.silent, AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh) |
           when(seen.f || (masked_ && seen.virtual_rc), AuthorityCondition::kModeF) |
           when(seen.device == Device::kOurs, AuthorityCondition::kDeviceOurs) |
           when(seen.virtual_rc, AuthorityCondition::kVirtualRcOn) |
           when(uses_virtual_rc_, AuthorityCondition::kNeedsVirtualRc);
  }
  void examine(const World& world, const AuthorityStep& made, const Choice& choice) {
    const bool commands = may_command(world.client.stage);
    const bool ours = world.autopilot.device == Device::kOurs && world.autopilot.f &&
                      (!uses_virtual_rc_ || world.autopilot.virtual_rc);
    if (commands && choice.telemetry_arrives && !ours) {
      fail("a command is sent although this tick's telemetry reports the loss of authority");
    }
    if (commands && world.seen.silent) {
      fail("a command is sent although the link has been silent beyond its limit");
    }
    const bool leaves = made.action != AuthorityAction::kNone && made.action != AuthorityAction::kReleaseControl;
    if (world.must_be_silent && (commands || leaves)) {
      fail("a byte is sent after a loss without a new order");
    }
    examine_spacing(world, made);
  }
  void examine_spacing(const World& world, const AuthorityStep& made) {
    if (made.action == AuthorityAction::kRequestControl && world.since_obtain < kSpacingUnits) {
      fail("two requests for control within two seconds");
    }
    if (made.action == AuthorityAction::kSwitchVirtualRcOn && world.since_on < kSpacingUnits) {
      fail("two Virtual RC switches within two seconds");
    }
    if (made.action == AuthorityAction::kRequestControl && world.obtains_since_ask >= kRequestsPerAction) {
      fail("more than three requests for one order");
    }
    if (made.action == AuthorityAction::kSwitchVirtualRcOn && world.ons_since_ask >= kRequestsPerAction) {
      fail("more than three Virtual RC switches for one order");
    }
  }

  void act(World& world, AuthorityAction action, const Choice& choice) const {
    if (action == AuthorityAction::kNone) {
      return;
    }
    if (action == AuthorityAction::kRequestControl) {
      world.since_obtain = 0;
      world.obtains_since_ask = std::min<std::uint64_t>(world.obtains_since_ask + 1, 3);
    }
    if (action == AuthorityAction::kSwitchVirtualRcOn) {
      world.since_on = 0;
      world.ons_since_ask = std::min<std::uint64_t>(world.ons_since_ask + 1, 3);
    }
    const Ack ack = choice.request_arrives ? receive(world.autopilot, action) : Ack::kNone;
    if (waits_for_answer(action)) {
      world.open = true;
      world.open_old = false;
      world.question = action;
      world.ack = ack;
    }
  }

  void expand(const World& world) {
    for (unsigned bits = 0; bits < 16U * kEvents * kOperators && !failed(); ++bits) {
      Choice choice{.event = static_cast<Event>(bits / 16U % kEvents),
                    .acts = static_cast<Operator>(bits / 16U / kEvents),
                    .telemetry_arrives = (bits & 1U) != 0,
                    .push_arrives = (bits & 2U) != 0,
                    .ack_arrives = (bits & 4U) != 0,
                    .request_arrives = true,
                    .time_passes = (bits & 8U) != 0};
      const bool push_matters = world.autopilot.device == Device::kOurs;
      const bool ack_matters = world.open && world.ack != Ack::kNone;
      if ((!choice.push_arrives && !push_matters) || (!choice.ack_arrives && !ack_matters)) {
        continue;
      }
      const World after = step_world(world, choice);
      add(after);
      if (after.open || after.since_on == 0 || after.client.since_release == core::Duration{0}) {
        // A request may have been sent; it may be lost.
        choice.request_arrives = false;
        add(step_world(world, choice));
      }
    }
  }

  void add(const World& world) {
    const std::uint64_t key = pack(world) + 1;  // 0 marks an empty slot
    auto place = static_cast<std::size_t>(key * 0x9E3779B97F4A7C15ULL >> (64U - kTableBits));
    while (table_[place] != 0 && table_[place] != key) {
      place = (place + 1) & ((std::size_t{1} << kTableBits) - 1);
    }
    if (table_[place] == 0) {
      table_[place] = key;
      order_.push_back(key - 1);
      if (order_.size() > table_.size() / 2) {
        fail("more states than the table can hold");
      }
    }
  }

  void fail(const std::string& what) {
    if (failure_.empty()) {
      failure_ = what;
    }
  }

  bool uses_virtual_rc_;
  bool masked_;
  std::vector<std::uint64_t> table_;
  std::vector<std::uint64_t> order_;
  std::uint64_t steps_ = 0;
  std::bitset<kStageCount> stages_;
  std::string failure_;
};

struct Variant {
  const char* name;
  bool uses_virtual_rc;
  bool masked;
};
class AuthorityWalk : public ::testing::TestWithParam<Variant> {};
INSTANTIATE_TEST_SUITE_P(Product, AuthorityWalk,
                         ::testing::Values(Variant{"VirtualRc", true, false},
                                           Variant{"VirtualRcHidingTheModeSwitch", true, true},
                                           Variant{"Movement", false, false}),
                         [](const auto& tested) { return tested.param.name; });

/// Continues with an order and without faults. @returns the final stage.
AuthorityStage way_to_control(Walk& walk, World world) {
  for (int n = 0; n < 80 && !may_command(world.client.stage); ++n) {
    const AuthorityStage stage = world.client.stage;
    const bool waits =
        !world.client.control_requested &&
        (stage == AuthorityStage::kReady || stage == AuthorityStage::kSilent || stage == AuthorityStage::kSilentCold);
    const Event event = !world.autopilot.f                          ? Event::kReturnF
                        : world.autopilot.device == Device::kMobile ? Event::kMobileEnds
                                                                    : Event::kNothing;
    world = walk.step_world(world, {.event = event, .acts = waits ? Operator::kAsks : Operator::kNothing});
  }
  return world.client.stage;
}

/// Continues with the operator's stop on a good line. @returns units until the transmitter has control; -1: not in ten.
int way_to_the_pilot(Walk& walk, World world) {
  for (int n = 0; n < 40; ++n) {
    if (world.autopilot.device != Device::kOurs && !world.autopilot.virtual_rc) {
      return n / 4;
    }
    // Between units there are steps of zero time in which only answers arrive: start-up messages take negligible time.
    world =
        walk.step_world(world, {.acts = n == 0 ? Operator::kReleases : Operator::kNothing, .time_passes = n % 4 == 3});
  }
  return -1;
}

TEST_P(AuthorityWalk, NoOrderOfEventsBreaksAPromise) {
  RecordProperty("promise", "R4,R15");
  Walk walk(GetParam().uses_virtual_rc, GetParam().masked);
  walk.run();
  EXPECT_EQ(walk.failure(), "");
  RecordProperty("states", static_cast<int>(walk.states().size()));
  std::cout << walk.states().size() << " states, " << walk.steps() << " steps\n";
  // The movement channel has no stage for enabling Virtual RC.
  EXPECT_EQ(walk.stages().count(), kStageCount - (GetParam().uses_virtual_rc ? 0U : 1U)) << walk.stages();

  // From each state there must be a way to control and one to the pilot. The latter takes at most two units of half a
  // second: one for the first and second release, and one in case the first was just too early.
  const std::size_t stride = walk.states().size() / 20000 + 1;
  for (std::size_t i = 0; i < walk.states().size(); i += stride) {
    const World world = unpack(walk.states()[i]);
    ASSERT_EQ(way_to_control(walk, world), AuthorityStage::kInControl)
        << "from state " << i << ", " << name(world.client.stage);
    const int units = way_to_the_pilot(walk, world);
    ASSERT_TRUE(units >= 0 && units <= 2) << units << " from state " << i << ", " << name(world.client.stage);
  }
}

}  // namespace
}  // namespace m100::safety::walk
