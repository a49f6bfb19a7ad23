// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/core/time.h"

namespace m100::safety {

/// Measures for how long the autopilot's flight status has been "on the ground" since it was "in the air". A hop of
/// less than 1.5 s does not end the contact; it adds its own duration, but at most that of the contact before it. While
/// the poses read high, time in the air after a contact counts as contact. The duration is zero before the first "in
/// the air".
class GroundContact {
 public:
  static constexpr core::Duration kHop = std::chrono::milliseconds(1500);

  /// @param poses_read_high HeightConsistency::reads_high(). @param received_at of the newest status, also if not new
  void update(bool on_ground, bool poses_read_high, core::TimePoint received_at) {
    if (on_ground || (poses_read_high && duration() > core::Duration{0})) {
      duration_ += received_at - last_ + core::clamp(last_ - touched_, core::Duration{0}, duration_);
      touched_ = received_at;
    } else if (!has_flown_ || received_at - touched_ >= kHop) {
      has_flown_ = true;
      duration_ = core::Duration{0};
    }
    last_ = received_at;
  }
  core::Duration duration() const { return has_flown_ ? duration_ : core::Duration{0}; }

 private:
  bool has_flown_ = false;
  core::Duration duration_{0};
  core::TimePoint touched_{};
  core::TimePoint last_{};
};

}  // namespace m100::safety
