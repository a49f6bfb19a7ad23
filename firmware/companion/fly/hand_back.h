// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/companion/fly/listener.h"
#include "firmware/companion/fly/text_line.h"
#include "firmware/link/serial_link.h"

namespace m100::companion {

/// The end of control, the same for a flight and for the handshake (promise R15): from when control is to go back, or
/// is gone, until new telemetry shows whose it is. The link gives back; here stands when that is over, and what the
/// operator reads where it does not succeed. No heap.
class HandBack {
 public:
  /// Longer than this, and the operator reads what the pilot has to do.
  static constexpr core::Duration kTold = std::chrono::seconds(1);
  /// A port that is gone for longer does not come back in this session: where the program was to end, it ends.
  static constexpr core::Duration kPortReturns = std::chrono::seconds(5);

  enum class State : std::uint8_t {
    kGoesOn,   ///< control may still be ours
    kOver,     ///< telemetry shows that it is not
    kGivesUp,  ///< unknown: the port is gone for good, or the operator insists
  };

  explicit HandBack(Listener& listener) : listener_(listener) {}

  /// Control is asked for. @param outages of the port so far: an autopilot behind a port that was gone may be another.
  void note_ask(std::uint32_t outages) { outages_before_ = outages; }
  /// Control is to go back, or is gone. @param stops signals to end so far, that this answers.
  void begin(core::TimePoint now, std::uint32_t stops);
  /// Each tick, in every phase: what the pilot has to do where control may be ours and cannot be given back.
  void watch(core::TimePoint now, const link::AuthorityView& view);
  /// Each tick after begin(). Says whose control is when it is over.
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
  core::TimePoint port_here_{};  ///< the port was there
  std::uint32_t outages_before_ = 0;
  std::uint32_t stops_before_ = 0;
  bool is_with_the_pilot_ = false;
  Trouble told_ = Trouble::kNone;
};

}  // namespace m100::companion
