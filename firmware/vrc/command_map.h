// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/assert.h"
#include "firmware/core/expected.h"
#include "firmware/ctl/command.h"
#include "firmware/model/vehicle.h"
#include "firmware/vrc/stick_map.h"
#include "firmware/vrc/sticks.h"

namespace m100::vrc {

/// What a stick does with the part of a command that it cannot represent.
enum class StickRule : std::uint8_t {
  kCarriesRemainder,  ///< adds it to the next command
  kAsThePaper,        ///< drops it; a stick inside the dead zone goes to the zone's edge (paper, III-B.5)
};

/// SI command <-> the four sticks of one vehicle. Only here do the law's commands become counts.
///
/// A stick cannot represent every command (dead zone with a jump, whole counts). The part that it does not represent is
/// added to the next command of that stick (error feedback), so that the mean over a few messages is the command. The
/// remainder is at most the dead zone's half width plus one count; StickRule::kAsThePaper has none.
class CommandMap {
 public:
  /// Precondition (asserted): finite trims, dead zones of at least zero, stick exponents and gain asymmetries above
  /// zero.
  explicit CommandMap(const model::Vehicle& vehicle, StickRule rule = StickRule::kCarriesRemainder);

  /// The sticks for a command. Call it once per stick message that leaves.
  /// kOutOfRange: a number is not finite; nothing is changed then.
  core::Expected<Sticks> to_sticks(const ctl::Command<float>& command);
  /// The command that these sticks give: pass it to the observer and to the law.
  ctl::Command<float> to_command(const Sticks& sticks) const;
  /// All sticks at their trims: level, no climb, no turn.
  Sticks neutral() const;
  /// Sets the neutrals of roll and pitch, the middles of their dead zones, to counts from the vehicle file's trims.
  void set_learned_trims(float roll_vrc, float pitch_vrc) {
    maps_[kRoll].neutral_vrc = trims_vrc_[kRoll] + roll_vrc;
    maps_[kPitch].neutral_vrc = trims_vrc_[kPitch] + pitch_vrc;
  }
  /// Sets the remainders of all sticks to zero.
  void reset() { remainder_ = {}; }

  /// @param stick  0 roll, 1 pitch, 2 throttle, 3 yaw
  const StickMap& map(std::size_t stick) const {
    M100_ASSERT(stick < kSticks);
    return maps_[stick];
  }
  const StickMap& roll() const { return maps_[kRoll]; }
  const StickMap& pitch() const { return maps_[kPitch]; }
  const StickMap& throttle() const { return maps_[kThrottle]; }
  const StickMap& yaw() const { return maps_[kYaw]; }

 private:
  enum StickIndex : std::size_t { kRoll, kPitch, kThrottle, kYaw, kSticks };
  Stick modulated(StickIndex index, float command_si);

  std::array<StickMap, kSticks> maps_;
  std::array<float, 2> trims_vrc_{};  ///< neutrals of roll and pitch by the vehicle file
  std::array<float, kSticks> remainder_{};
  StickRule rule_;
};

}  // namespace m100::vrc
