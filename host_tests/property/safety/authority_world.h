// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "firmware/safety/authority.h"
#include "firmware/safety/authority_table.h"

// The world of the exhaustive walk, packed into 64 bits: an abstract autopilot, its last telemetry, the client's state.

namespace m100::safety::walk {

/// The unit of time: every threshold is a multiple of it (ack and silence 1, confirming and listening 2, spacing and
/// items 4, pausing 10). A step takes zero or one unit, so that events can also happen at the same time, in any order.
inline constexpr core::Duration kUnit = std::chrono::milliseconds(500);
static_assert(kRequestSpacing % kUnit == core::Duration{0} && kConfirmTime % kUnit == core::Duration{0} &&
              kListenTime % kUnit == core::Duration{0} && kPauseTime % kUnit == core::Duration{0} &&
              kItemsTime % kUnit == core::Duration{0});
inline constexpr std::uint64_t kSpacingUnits = static_cast<std::uint64_t>(kRequestSpacing / kUnit);

enum class Device : std::uint8_t { kRc, kMobile, kOurs };
enum class Ack : std::uint8_t { kNone, kDone, kSendAgain, kRefused, kNotActivated };
enum class Event : std::uint8_t {
  kNothing,
  kLeaveF,
  kReturnF,
  kMobileTakes,
  kMobileEnds,
  kRestart,
  kEndVirtualRc,
  kPortBack,
};
enum class Operator : std::uint8_t { kNothing, kAsks, kReleases };
inline constexpr std::uint8_t kEvents = 8;
inline constexpr std::uint8_t kOperators = 3;

/// State of the autopilot, actual or as its last telemetry reported it.
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
  bool open_old = false;  ///< waiting for one unit or more: given up at the next step
  AuthorityAction question = AuthorityAction::kNone;
  Ack ack = Ack::kNone;  ///< answer on its way
  Autopilot autopilot;
  Seen seen;
  // The examiner's state, independent of the client's.
  std::uint64_t since_obtain = kSpacingUnits;
  std::uint64_t since_on = kSpacingUnits;
  std::uint64_t obtains_since_ask = 0;
  std::uint64_t ons_since_ask = 0;
  bool must_be_silent = false;
};

/// Makes states equal that have the same future, so that the walk ends.
inline void canonicalise(World& world) {
  AuthorityState& client = world.client;
  client.reason = AuthorityReason::kNone;
  client.since_request = std::min(client.since_request, kRequestSpacing);
  client.since_switch = std::min(client.since_switch, kRequestSpacing);
  client.since_release = client.since_release < kReleaseSpacing ? core::Duration{0} : kAgeLimit;
  client.releases = 0;  // the pause between releases only delays; GivingBackIsRepeated... tests the count
  const bool timed = client.stage == AuthorityStage::kListening || client.stage == AuthorityStage::kPausing ||
                     client.stage == AuthorityStage::kConfirming || client.stage == AuthorityStage::kEnabling ||
                     client.stage == AuthorityStage::kAwaitingTelemetry;
  client.since_entry = timed ? std::min(client.since_entry, kPauseTime) : core::Duration{0};
  if (!world.open) {
    world.open_old = false;
    world.question = AuthorityAction::kNone;
    world.ack = Ack::kNone;
  }
  if (!(kAcquiring | kHolding).has(client.stage)) {
    client.requests = 0;  // the next order sets them to zero
    client.switches = 0;
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

inline std::uint64_t units(core::Duration duration) { return static_cast<std::uint64_t>(duration / kUnit); }

inline std::uint64_t pack(const World& w) {
  Packer p;
  p.put(static_cast<std::uint64_t>(w.client.stage), 4);
  p.put(w.client.control_requested, 1);
  p.put(w.client.requests, 2);
  p.put(w.client.switches, 2);
  p.put(w.client.release_pending, 1);
  p.put(w.client.must_release, 1);
  p.put(w.client.since_release >= kReleaseSpacing, 1);
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

inline World unpack(std::uint64_t word) {
  Unpacker u(word);
  World w;
  w.client.stage = static_cast<AuthorityStage>(u.get(4));
  w.client.control_requested = u.get(1) != 0;
  w.client.requests = static_cast<std::uint8_t>(u.get(2));
  w.client.switches = static_cast<std::uint8_t>(u.get(2));
  w.client.release_pending = u.get(1) != 0;
  w.client.must_release = u.get(1) != 0;
  w.client.since_release = u.get(1) != 0 ? kAgeLimit : core::Duration{0};
  w.client.since_entry = static_cast<std::int64_t>(u.get(4)) * kUnit;
  w.client.since_request = static_cast<std::int64_t>(u.get(3)) * kUnit;
  w.client.since_switch = static_cast<std::int64_t>(u.get(3)) * kUnit;
  w.client.reason = AuthorityReason::kNone;
  w.open = u.get(1) != 0;
  w.open_old = u.get(1) != 0;
  w.question = static_cast<AuthorityAction>(u.get(3));
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

/// @returns true if authority was lost, so that a push is on its way.
inline bool happen(Autopilot& autopilot, Event event) {
  const bool had = autopilot.device == Device::kOurs;
  switch (event) {
    case Event::kNothing:
    case Event::kPortBack:  // an event at the client's end of the line
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
      return false;  // without a push
    case Event::kEndVirtualRc:
      autopilot.virtual_rc = false;
      break;
  }
  return had && autopilot.device != Device::kOurs;
}

inline Ack obtain(Autopilot& autopilot) {
  if (!autopilot.activated) {
    return Ack::kNotActivated;
  }
  if (!autopilot.f) {
    return Ack::kRefused;
  }
  if (autopilot.device == Device::kMobile) {
    return Ack::kSendAgain;
  }
  autopilot.release_once = false;
  if (autopilot.device != Device::kOurs) {
    autopilot.asked_once = !autopilot.asked_once;
    autopilot.device = autopilot.asked_once ? Device::kRc : Device::kOurs;
  }
  return autopilot.device == Device::kOurs ? Ack::kDone : Ack::kSendAgain;
}

inline Ack give_back(Autopilot& autopilot) {
  autopilot.virtual_rc = false;
  if (!autopilot.f || !autopilot.activated) {
    return autopilot.f ? Ack::kNotActivated : Ack::kRefused;
  }
  if (autopilot.device == Device::kOurs) {
    autopilot.release_once = !autopilot.release_once;
    autopilot.device = autopilot.release_once ? Device::kOurs : Device::kRc;
  }
  return autopilot.device == Device::kOurs ? Ack::kSendAgain : Ack::kDone;
}

/// The autopilot's reaction to a request that reaches it (protocol, sections 6.1, 7 and 11).
inline Ack receive(Autopilot& autopilot, AuthorityAction request) {
  switch (request) {
    case AuthorityAction::kRequestVersion:
    case AuthorityAction::kSetRates:
      return Ack::kDone;
    case AuthorityAction::kActivate:
      autopilot.activated = true;
      return Ack::kDone;
    case AuthorityAction::kRequestControl:
      return obtain(autopilot);
    case AuthorityAction::kSwitchVirtualRcOn:
      autopilot.virtual_rc = autopilot.virtual_rc || (autopilot.f && autopilot.activated);
      return Ack::kNone;
    case AuthorityAction::kReleaseControl:
      return give_back(autopilot);
    case AuthorityAction::kNone:
      break;
  }
  return Ack::kNone;
}

inline AuthorityCondition sign_of(Ack ack) {
  switch (ack) {
    case Ack::kDone:
      return AuthorityCondition::kDone;
    case Ack::kSendAgain:
      return AuthorityCondition::kSendAgain;
    case Ack::kRefused:
      return AuthorityCondition::kRefused;
    case Ack::kNotActivated:
      return AuthorityCondition::kNotActivated;
    case Ack::kNone:
      break;
  }
  return AuthorityCondition::kNone;
}

/// The client ignores the answer to a release, because telemetry shows the result.
inline bool waits_for_answer(AuthorityAction action) {
  return action != AuthorityAction::kNone && action != AuthorityAction::kSwitchVirtualRcOn &&
         action != AuthorityAction::kReleaseControl;
}

}  // namespace m100::safety::walk
