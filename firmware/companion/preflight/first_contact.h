// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/companion/operator/operator_log.h"
#include "firmware/link/serial_link.h"

namespace m100::companion {

/// Reports during a handshake how the autopilot behaves where DJI's documents say nothing. Each line has a key of
/// guide/FIRST_CONTACT.md and says whether the emulated autopilot behaves in this way. Sends nothing.
class FirstContact {
 public:
  explicit FirstContact(OperatorLog& operator_log) : operator_log_(operator_log) {}

  /// Call it after each tick of the link.
  void update(core::TimePoint now, const link::SerialLink& link);

 private:
  void update_start(core::TimePoint now, const link::SerialLink& link);
  void update_control(core::TimePoint now, const link::SerialLink& link);
  void report(core::TimePoint now, std::string_view key, bool seen, bool assumed);

  OperatorLog& operator_log_;
  safety::AuthorityStage last_stage_ = safety::AuthorityStage::kListening;
  bool streamed_before_activation_ = false;
  core::TimePoint ready_since_{};  ///< the epoch: never ready
  bool rate_reported_ = false;
  std::uint32_t requests_ = 0;
  core::TimePoint controls_since_{};  ///< the epoch: never had control
  bool lost_reported_ = false;
  bool control_reported_ = false;
};

}  // namespace m100::companion
