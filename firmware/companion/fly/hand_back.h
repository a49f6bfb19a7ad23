// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/companion/fly/listener.h"
#include "firmware/companion/fly/text_line.h"
#include "firmware/link/serial_link.h"

namespace m100::companion {

/// The end of control, the same for a flight and for the handshake (promise R15): from the moment when control is to go
/// back, or is lost, until new telemetry shows who has it. The link gives control back; this class decides when that is
/// over, and tells the operator what to do if it does not succeed. No heap.
class HandBack {
 public:
  /// After this time the operator is told what the pilot has to do.
  static constexpr core::Duration kTold = std::chrono::seconds(1);
  /// After this time a port that is gone is not expected back: if the program was to end, it ends.
  static constexpr core::Duration kPortReturns = std::chrono::seconds(5);

  enum class State : std::uint8_t {
    kGoesOn,   ///< control may still be ours
    kOver,     ///< telemetry shows that control is not ours
    kGivesUp,  ///< unknown: the port is gone for good, or the operator insists
  };

  explicit HandBack(Listener& listener) : listener_(listener) {}

  /// Notes that control is requested. @param outages of the port so far: after one it may lead to another autopilot.
  void note_ask(std::uint32_t outages) { outages_before_ = outages; }
  /// Begins: control is to go back, or is lost. @param stops signals to end so far, which this hand-back answers.
  void begin(core::TimePoint now, std::uint32_t stops);
  /// Call it each tick, in every phase: tells what the pilot has to do if control may be ours and cannot be given back.
  void watch(core::TimePoint now, const link::AuthorityView& view);
  /// Call it each tick after begin(). Tells who has control when the hand-back is over.
  State look(core::TimePoint now, const link::SerialLink& link, std::uint32_t stops);
  /// After kOver: the transmitter is on and has control.
  bool is_with_the_pilot() const { return is_with_the_pilot_; }
  core::TimePoint since() const { return since_; }

 private:
  enum class Trouble : std::uint8_t { kNone, kStillOurs, kUnheard, kNothingHeard, kPortGone, kPortAway };
  Trouble trouble_of(core::TimePoint now, const link::AuthorityView& view) const;
  void tell_whose(core::TimePoint now, const link::SerialLink& link);

  Listener& listener_;
  bool begun_ = false;
  core::TimePoint since_{};
  core::TimePoint port_here_{};  ///< when the port was last there
  std::uint32_t outages_before_ = 0;
  std::uint32_t stops_before_ = 0;
  bool is_with_the_pilot_ = false;
  Trouble told_ = Trouble::kNone;
};

}  // namespace m100::companion
