// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::safety {

/// Measures for how long the autopilot's flight status has been "on the ground" since it was "in the air". "In the air"
/// for less than a second (a hop) does not end the contact, and its time is not counted: at hover thrust the aircraft
/// leaves the ground by millimetres, and takes more than half a second to come back. Without any "in the air" before,
/// "on the ground" is no evidence of a landing.
class GroundContact {
 public:
  static constexpr core::Duration kHop = std::chrono::seconds(1);

  /// @param received_at when the newest status came; may be the same as in the call before
  void update(bool on_ground, core::TimePoint received_at) {
    if (on_ground) {
      duration_ += received_at - last_;
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
