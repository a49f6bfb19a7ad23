// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::safety {

/// Measures for how long the autopilot's flight status has said "on the ground" since it said "in the air". A status
/// that never said "in the air" is no evidence of a landing.
class GroundContact {
 public:
  /// @param received_at when the newest status came
  void update(bool on_ground, core::TimePoint received_at) {
    if (!on_ground) {
      has_flown_ = true;
      first_ = received_at;
    }
    last_ = received_at;
  }
  /// From the last status "in the air" to the newest one; zero: that one says "in the air".
  core::Duration duration() const { return has_flown_ ? last_ - first_ : core::Duration{0}; }

 private:
  bool has_flown_ = false;
  core::TimePoint first_{};
  core::TimePoint last_{};
};

}  // namespace m100::safety
