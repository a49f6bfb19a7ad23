// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/companion/operator/text_line.h"
#include "firmware/safety/supervisor.h"

namespace m100::companion {

/// What can be wrong where poses or attitude are refused or missing.
enum class RefusalCause : std::uint8_t {
  kLeverArm,
  kClimb,
  kPlace,
  kHeading,
  kCompass,
  kAge,
  kForce,
  kAttitude,
  kAnswer
};
inline constexpr std::size_t kRefusalCauseCount = 9;

/// Whether poses come but are refused; the newest used one may be too old before they were refused for long enough.
bool poses_are_refused(safety::FailsafeReason reason, const safety::Observation& seen);

/// The causes that what was seen leaves, the likeliest first.
class RefusalCauses {
 public:
  /// @param reason empty for one that is none of poses or attitude
  RefusalCauses(safety::FailsafeReason reason, const safety::Observation& seen);

  std::span<const RefusalCause> list() const { return std::span(causes_).first(count_); }

 private:
  std::array<RefusalCause, kRefusalCauseCount> causes_{};
  std::size_t count_ = 0;
};

/// Of the heading of a pose: the observer's innovation gate. A pose that turned by less was refused for its place.
inline constexpr double kHeadingGate_rad = 0.35;

/// "; likeliest: the heading of the poses (look at ...)": the first cause with its remedy, then the others. The lever
/// arm has a sentence of its own.
TextLine& add_causes(TextLine& line, const RefusalCauses& causes);

}  // namespace m100::companion
