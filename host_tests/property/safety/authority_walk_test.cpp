// SPDX-License-Identifier: BSD-3-Clause
// An exhaustive walk of the product of the authority table with an abstract autopilot, line and operator, in digital
// time. Every state that any order of events can reach is visited once, every thing that can happen next is tried.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

#include "firmware/safety/authority.h"
#include "firmware/safety/authority_table.h"

namespace m100::safety {
namespace {

/// The unit of time: every threshold is a multiple of it (ack and silence 1, confirming and listening 2, spacing and
/// items 4, pausing 10). A step takes none or one of it, so things can also happen in the same instant, in any order.
constexpr core::Duration kUnit = std::chrono::milliseconds(500);
static_assert(kRequestSpacing % kUnit == core::Duration{0} && kConfirmTime % kUnit == core::Duration{0} &&
              kListenTime % kUnit == core::Duration{0} && kPauseTime % kUnit == core::Duration{0} &&
              kItemsTime % kUnit == core::Duration{0});
constexpr std::uint64_t kSpacingUnits = static_cast<std::uint64_t>(kRequestSpacing / kUnit);

enum class Device : std::uint8_t { kRc, kMobile, kOurs };
enum class Ack : std::uint8_t { kNone, kDone, kAgain, kRefused, kNotActivated };
enum class Event : std::uint8_t { kNothing, kLeaveF, kReturnF, kMobileTakes, kMobileEnds, kRestart, kEndVirtualRc };
enum class Operator : std::uint8_t { kNothing, kAsks, kReleases };
constexpr std::uint8_t kEvents = 7;
constexpr std::uint8_t kOperators = 3;

/// What the autopilot is, and what its last telemetry said it was.
struct Autopilot {
  bool f = true;
  bool activated = false;
  bool asked_once = false;
  bool release_once = false;
  bool virtual_rc = false;
  Device device = Device::kRc;
};
struct Seen {
  bool f = false;
  bool virtual_rc = false;
  Device device = Device::kRc;
  bool silent = true;  ///< no telemetry for one unit or more
};

struct World {
  AuthorityState client;
  bool open = false;      ///< a request waits for its answer
  bool open_old = false;  ///< for one unit or more: given up at the next step
  Action question = Action::kNone;
  Ack ack = Ack::kNone;  ///< on its way
  Autopilot autopilot;
  Seen seen;
  // The examiner's own memory, apart from the client's.
  std::uint64_t since_obtain = kSpacingUnits;
  std::uint64_t since_on = kSpacingUnits;
  std::uint64_t obtains_since_ask = 0;
  std::uint64_t ons_since_ask = 0;
  bool must_be_silent = false;
};

/// Facts that make no difference to what can follow are made equal, so that the walk ends.
void canonicalise(World& world) {
  AuthorityState& client = world.client;
  client.reason = Reason::kNone;
  client.since_request = std::min(client.since_request, kRequestSpacing);
  client.since_switch = std::min(client.since_switch, kRequestSpacing);
  const bool timed = client.stage == Stage::kListening || client.stage == Stage::kPausing ||
                     client.stage == Stage::kConfirming || client.stage == Stage::kEnabling ||
                     client.stage == Stage::kAwaitingTelemetry;
  client.since_entry = timed ? std::min(client.since_entry, kPauseTime) : core::Duration{0};
  if (!world.open) {
    world.open_old = false;
    world.question = Action::kNone;
    world.ack = Ack::kNone;
  }
  if (!(kAcquiring | kHolding).has(client.stage)) {
    client.requests = 0;  // the next ask sets them to zero anyway
    client.switches = 0;
    client.releases = 0;
  }
}

class Packer {
 public:
  void put(std::uint64_t value, unsigned bits) {
    word_ |= value << used_;
    used_ += bits;
  }
  std::uint64_t word() const { return word_; }
  unsigned used() const { return used_; }

 private:
  std::uint64_t word_ = 0;
  unsigned used_ = 0;
};
class Unpacker {
 public:
  explicit Unpacker(std::uint64_t word) : word_(word) {}
  std::uint64_t get(unsigned bits) {
    const std::uint64_t value = word_ & ((std::uint64_t{1} << bits) - 1);
    word_ >>= bits;
    return value;
  }

 private:
  std::uint64_t word_;
};

std::uint64_t units(core::Duration duration) { return static_cast<std::uint64_t>(duration / kUnit); }

std::uint64_t pack(const World& w) {
  Packer p;
  p.put(static_cast<std::uint64_t>(w.client.stage), 4);
  p.put(w.client.asked, 1);
  p.put(w.client.requests, 2);
  p.put(w.client.switches, 2);
  p.put(w.client.releases, 2);
  p.put(units(w.client.since_entry), 4);
  p.put(units(w.client.since_request), 3);
  p.put(units(w.client.since_switch), 3);
  p.put(w.open, 1);
  p.put(w.open_old, 1);
  p.put(static_cast<std::uint64_t>(w.question), 3);
  p.put(static_cast<std::uint64_t>(w.ack), 3);
  p.put(w.autopilot.f, 1);
  p.put(w.autopilot.activated, 1);
  p.put(w.autopilot.asked_once, 1);
  p.put(w.autopilot.release_once, 1);
  p.put(w.autopilot.virtual_rc, 1);
  p.put(static_cast<std::uint64_t>(w.autopilot.device), 2);
  p.put(w.seen.f, 1);
  p.put(w.seen.virtual_rc, 1);
  p.put(static_cast<std::uint64_t>(w.seen.device), 2);
  p.put(w.seen.silent, 1);
  p.put(w.since_obtain, 3);
  p.put(w.since_on, 3);
  p.put(w.obtains_since_ask, 2);
  p.put(w.ons_since_ask, 2);
  p.put(w.must_be_silent, 1);
  EXPECT_LE(p.used(), 64U);
  return p.word();
}

World unpack(std::uint64_t word) {
  Unpacker u(word);
  World w;
  w.client.stage = static_cast<Stage>(u.get(4));
  w.client.asked = u.get(1) != 0;
  w.client.requests = static_cast<std::uint8_t>(u.get(2));
  w.client.switches = static_cast<std::uint8_t>(u.get(2));
  w.client.releases = static_cast<std::uint8_t>(u.get(2));
  w.client.since_entry = static_cast<std::int64_t>(u.get(4)) * kUnit;
  w.client.since_request = static_cast<std::int64_t>(u.get(3)) * kUnit;
  w.client.since_switch = static_cast<std::int64_t>(u.get(3)) * kUnit;
  w.client.reason = Reason::kNone;
  w.open = u.get(1) != 0;
  w.open_old = u.get(1) != 0;
  w.question = static_cast<Action>(u.get(3));
  w.ack = static_cast<Ack>(u.get(3));
  w.autopilot.f = u.get(1) != 0;
  w.autopilot.activated = u.get(1) != 0;
  w.autopilot.asked_once = u.get(1) != 0;
  w.autopilot.release_once = u.get(1) != 0;
  w.autopilot.virtual_rc = u.get(1) != 0;
  w.autopilot.device = static_cast<Device>(u.get(2));
  w.seen.f = u.get(1) != 0;
  w.seen.virtual_rc = u.get(1) != 0;
  w.seen.device = static_cast<Device>(u.get(2));
  w.seen.silent = u.get(1) != 0;
  w.since_obtain = u.get(3);
  w.since_on = u.get(3);
  w.obtains_since_ask = u.get(2);
  w.ons_since_ask = u.get(2);
  w.must_be_silent = u.get(1) != 0;
  return w;
}

/// @returns true: authority was lost, so a push is on its way.
bool happen(Autopilot& autopilot, Event event) {
  const bool had = autopilot.device == Device::kOurs;
  switch (event) {
    case Event::kNothing:
      break;
    case Event::kLeaveF:
      autopilot = {.f = false, .activated = autopilot.activated};
      break;
    case Event::kReturnF:
      autopilot.f = true;
      break;
    case Event::kMobileTakes:
      autopilot.device = Device::kMobile;
      autopilot.virtual_rc = autopilot.asked_once = false;
      break;
    case Event::kMobileEnds:
      autopilot.device = autopilot.device == Device::kMobile ? Device::kRc : autopilot.device;
      break;
    case Event::kRestart:
      autopilot = {.f = autopilot.f};
      return false;  // it says nothing
    case Event::kEndVirtualRc:
      autopilot.virtual_rc = false;
      break;
  }
  return had && autopilot.device != Device::kOurs;
}

/// What the autopilot makes of a request that reaches it (protocol, sections 6.1, 7 and 11).
Ack receive(Autopilot& autopilot, Action request) {
  switch (request) {
    case Action::kAskVersion:
    case Action::kSetRates:
      return Ack::kDone;
    case Action::kActivate:
      autopilot.activated = true;
      return Ack::kDone;
    case Action::kRequestControl:
      if (!autopilot.activated) {
        return Ack::kNotActivated;
      }
      if (!autopilot.f) {
        return Ack::kRefused;
      }
      if (autopilot.device == Device::kMobile) {
        return Ack::kAgain;
      }
      autopilot.release_once = false;
      if (autopilot.device != Device::kOurs) {
        autopilot.asked_once = !autopilot.asked_once;
        autopilot.device = autopilot.asked_once ? Device::kRc : Device::kOurs;
      }
      return autopilot.device == Device::kOurs ? Ack::kDone : Ack::kAgain;
    case Action::kSwitchVirtualRcOn:
      autopilot.virtual_rc = autopilot.virtual_rc || (autopilot.f && autopilot.activated);
      return Ack::kNone;
    case Action::kReleaseControl:
      autopilot.virtual_rc = false;
      if (!autopilot.f || !autopilot.activated) {
        return autopilot.f ? Ack::kNotActivated : Ack::kRefused;
      }
      if (autopilot.device == Device::kOurs) {
        autopilot.release_once = !autopilot.release_once;
        autopilot.device = autopilot.release_once ? Device::kOurs : Device::kRc;
      }
      return autopilot.device == Device::kOurs ? Ack::kAgain : Ack::kDone;
    case Action::kNone:
      break;
  }
  return Ack::kNone;
}

Fact fact_of(Ack ack) {
  switch (ack) {
    case Ack::kDone:
      return Fact::kDone;
    case Ack::kAgain:
      return Fact::kAgain;
    case Ack::kRefused:
      return Fact::kRefused;
    case Ack::kNotActivated:
      return Fact::kNotActivated;
    case Ack::kNone:
      break;
  }
  return Fact::kNone;
}

bool waits_for_answer(Action action) { return action != Action::kNone && action != Action::kSwitchVirtualRcOn; }

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
  /// @param masked the RC item shows Virtual RC's own mode while that is on, so mode F cannot be seen to end.
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

  /// One step of the world. Sets failure() if the examiner objects.
  World step_world(World world, const Choice& choice) {
    ++steps_;
    const core::Duration elapsed = choice.time_passes ? kUnit : core::Duration{0};
    const std::uint64_t passed = choice.time_passes ? 1 : 0;
    world.since_obtain = std::min(world.since_obtain + passed, kSpacingUnits);
    world.since_on = std::min(world.since_on + passed, kSpacingUnits);
    world.seen.silent = world.seen.silent || choice.time_passes;

    Fact facts = Fact::kNone;
    if (happen(world.autopilot, choice.event) && choice.push_arrives) {
      facts |= Fact::kLostPush;
    }
    if (choice.telemetry_arrives) {
      // A restart is seen by the autopilot's clock in the first telemetry after it; here it is the same step.
      facts |= when(choice.event == Event::kRestart, Fact::kRestarted);
      world.seen = {world.autopilot.f, world.autopilot.virtual_rc, world.autopilot.device, false};
    }
    if (world.open && world.ack != Ack::kNone && choice.ack_arrives) {
      facts |= fact_of(world.ack);
      world.open = false;
    } else if (world.open && world.open_old) {
      facts |= Fact::kNoAnswer;
      world.open = false;
    }
    world.open_old = world.open && (world.open_old || choice.time_passes);
    facts |= operator_fact(world, choice.acts) | levels(world.seen);

    const bool was_busy = (kAcquiring | kHolding).has(world.client.stage);
    const AuthorityStep made = step(world.client, facts, elapsed);
    world.client = made.state;
    world.open = world.open && !made.moved;
    stages_.set(static_cast<std::size_t>(world.client.stage));
    examine(world, made, choice);
    const bool silent_now = world.client.stage == Stage::kSilent || world.client.stage == Stage::kSilentCold;
    world.must_be_silent = world.must_be_silent || (was_busy && silent_now);
    act(world, made.action, choice);
    canonicalise(world);
    return world;
  }

 private:
  static constexpr unsigned kTableBits = 25;

  Fact operator_fact(World& world, Operator acts) const {
    if (acts == Operator::kAsks) {
      world.must_be_silent = false;
      world.obtains_since_ask = 0;
      world.ons_since_ask = 0;
      return Fact::kAsked;
    }
    return acts == Operator::kReleases ? Fact::kReleaseAsked : Fact::kNone;
  }
  Fact levels(const Seen& seen) const {
    return when(!seen.silent, Fact::kHeard | Fact::kItemsFresh) |
           when(seen.f || (masked_ && seen.virtual_rc), Fact::kModeF) |
           when(seen.device == Device::kOurs, Fact::kDeviceOurs) | when(seen.virtual_rc, Fact::kVirtualRcOn) |
           when(uses_virtual_rc_, Fact::kNeedsVirtualRc);
  }
  void examine(const World& world, const AuthorityStep& made, const Choice& choice) {
    const bool commands = may_command(world.client.stage);
    const bool ours = world.autopilot.device == Device::kOurs && world.autopilot.f &&
                      (!uses_virtual_rc_ || world.autopilot.virtual_rc);
    if (commands && choice.telemetry_arrives && !ours) {
      fail("a command leaves although telemetry of this tick says that authority is gone");
    }
    if (commands && world.seen.silent) {
      fail("a command leaves although the link has been silent for its limit");
    }
    if (world.must_be_silent && (commands || made.action != Action::kNone)) {
      fail("something leaves after a loss, before the operator asked");
    }
    if (made.action == Action::kRequestControl && world.since_obtain < kSpacingUnits) {
      fail("two requests for control within two seconds");
    }
    if (made.action == Action::kSwitchVirtualRcOn && world.since_on < kSpacingUnits) {
      fail("two Virtual RC switches within two seconds");
    }
    if (made.action == Action::kRequestControl && world.obtains_since_ask >= kRequestsPerAction) {
      fail("more than three requests for one ask");
    }
    if (made.action == Action::kSwitchVirtualRcOn && world.ons_since_ask >= kRequestsPerAction) {
      fail("more than three switches for one ask");
    }
  }

  void act(World& world, Action action, const Choice& choice) const {
    if (action == Action::kNone) {
      return;
    }
    if (action == Action::kRequestControl) {
      world.since_obtain = 0;
      world.obtains_since_ask = std::min<std::uint64_t>(world.obtains_since_ask + 1, 3);
    }
    if (action == Action::kSwitchVirtualRcOn) {
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
      if (after.open || after.since_on == 0) {  // something was sent, perhaps: it may have been lost
        choice.request_arrives = false;
        add(step_world(world, choice));
      }
    }
  }

  void add(const World& world) {
    const std::uint64_t key = pack(world) + 1;  // 0 marks an empty place
    auto place = static_cast<std::size_t>(key * 0x9E3779B97F4A7C15ULL >> (64U - kTableBits));
    while (table_[place] != 0 && table_[place] != key) {
      place = (place + 1) & ((std::size_t{1} << kTableBits) - 1);
    }
    if (table_[place] == 0) {
      table_[place] = key;
      order_.push_back(key - 1);
      if (order_.size() > table_.size() / 2) {
        fail("more states than the walk has room for");
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

TEST_P(AuthorityWalk, NoOrderOfEventsBreaksAPromise) {
  RecordProperty("promise", "R4");
  Walk walk(GetParam().uses_virtual_rc, GetParam().masked);
  walk.run();
  EXPECT_EQ(walk.failure(), "");
  RecordProperty("states", static_cast<int>(walk.states().size()));
  std::cout << walk.states().size() << " states, " << walk.steps() << " steps\n";
  // The movement channel has nothing to enable.
  EXPECT_EQ(walk.stages().count(), kStageCount - (GetParam().uses_virtual_rc ? 0U : 1U)) << walk.stages();

  // And from each state there is a way back to control, if the world is kind and the operator asks.
  const std::size_t stride = walk.states().size() / 20000 + 1;
  for (std::size_t i = 0; i < walk.states().size(); i += stride) {
    World world = unpack(walk.states()[i]);
    bool reached = false;
    for (int n = 0; n < 80 && !reached; ++n) {
      const Stage stage = world.client.stage;
      const bool waits =
          !world.client.asked && (stage == Stage::kReady || stage == Stage::kSilent || stage == Stage::kSilentCold);
      const Event event = !world.autopilot.f                          ? Event::kReturnF
                          : world.autopilot.device == Device::kMobile ? Event::kMobileEnds
                                                                      : Event::kNothing;
      world = walk.step_world(world, {.event = event, .acts = waits ? Operator::kAsks : Operator::kNothing});
      reached = may_command(world.client.stage);
    }
    ASSERT_TRUE(reached) << "from state " << i << ", stage " << name(unpack(walk.states()[i]).client.stage) << "; now "
                         << name(world.client.stage);
  }
}

/// The one exhaustive look at the table itself: whatever else is true at the same time, a loss ends control.
TEST(AuthorityTable, WhateverElseIsTrueALossEndsControl) {
  RecordProperty("promise", "R4");
  constexpr Fact kFlying = Fact::kHeard | Fact::kItemsFresh | Fact::kModeF | Fact::kDeviceOurs;
  for (std::uint32_t bits = 0; bits < (1U << 22U); ++bits) {
    const Fact facts = static_cast<Fact>(bits);
    const bool lost = !all(facts, kFlying) || any(facts, Fact::kRestarted | Fact::kLostPush) ||
                      (any(facts, Fact::kNeedsVirtualRc) && !any(facts, Fact::kVirtualRcOn));
    const Stage after = next(Stage::kInControl, facts);
    if (lost) {
      ASSERT_TRUE(after == Stage::kSilent || after == Stage::kSilentCold) << std::hex << bits;
    } else {
      ASSERT_EQ(after, any(facts, Fact::kReleaseAsked) ? Stage::kReleasing : Stage::kInControl) << std::hex << bits;
    }
  }
}

/// In every stage that is on the way to control, a loss leads to silence whatever else is true.
TEST(AuthorityTable, ALossOnTheWayToControlEndsTheAttempt) {
  for (const Stage stage : {Stage::kObtaining, Stage::kSpacing, Stage::kConfirming, Stage::kEnabling}) {
    for (std::uint32_t bits = 0; bits < (1U << 22U); bits += 1) {
      const Fact facts = static_cast<Fact>(bits);
      if (!all(facts, Fact::kHeard | Fact::kItemsFresh | Fact::kModeF) ||
          any(facts, Fact::kRestarted | Fact::kLostPush)) {
        const Stage after = next(stage, facts);
        ASSERT_TRUE(after == Stage::kSilent || after == Stage::kSilentCold) << name(stage) << " " << std::hex << bits;
      }
    }
  }
}

TEST(AuthorityTable, EveryReasonAndEveryStageHasAName) {
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    EXPECT_FALSE(name(static_cast<Stage>(stage)).empty());
  }
  for (const AuthorityRow& row : kAuthorityTable) {
    EXPECT_FALSE(name(row.reason).empty());
    const bool is_end = row.to == Stage::kSilent || row.to == Stage::kSilentCold || row.to == Stage::kPausing;
    EXPECT_EQ(is_end && remedy(row.reason).empty(), false) << name(row.reason) << " leaves a person without a remedy";
  }
}

}  // namespace
}  // namespace m100::safety
