// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/link/serial_link.h"

namespace m100::companion {

/// Watches the end of control, for a flight and for the handshake (promise R15): from when control is to go back, or is
/// lost, until new telemetry shows who has it. The link gives control back; this class decides when that is over, and
/// tells the operator what to do if it does not succeed. No heap.
class ReleaseMonitor {
 public:
  /// After this time the operator is told what the pilot has to do.
  static constexpr core::Duration kReportDelay = std::chrono::seconds(1);
  /// A port that is gone for longer is not expected back: confirm_release() then gives kAbandoned.
  static constexpr core::Duration kPortTimeout = std::chrono::seconds(5);

  enum class State : std::uint8_t {
    kPending,    ///< control may still be ours
    kReleased,   ///< telemetry shows that control is not ours, or it never was
    kAbandoned,  ///< unknown: the port is gone for good, or the operator insists
  };

  explicit ReleaseMonitor(OperatorLog& operator_log) : operator_log_(operator_log) {}

  /// Notes that control is requested. @param outages of the port so far: a later one may bring another autopilot.
  void control_requested(std::uint32_t outages) { outages_before_ = outages; }
  /// Begins: control is to go back, or is lost. @param stops signals to end so far. The next signal insists, but only
  /// after kReportDelay; if there was none so far, the second one does, because the first is the order to end.
  void begin(core::TimePoint now, std::uint32_t stops);
  /// Call it each tick, in every phase: tells what the pilot has to do if control may be ours and cannot be given back.
  void update(core::TimePoint now, const link::AuthorityView& view);
  /// Call it each tick after begin(). Tells who has control when the hand-back is over.
  State confirm_release(core::TimePoint now, const link::SerialLink& link, std::uint32_t stops);
  /// After kReleased: the transmitter is on and has control.
  bool pilot_in_control() const { return pilot_in_control_; }
  core::TimePoint since() const { return since_; }

 private:
  std::string_view problem_of(core::TimePoint now, const link::AuthorityView& view) const;
  void report_holder(core::TimePoint now, const link::SerialLink& link);

  OperatorLog& operator_log_;
  bool begun_ = false;
  core::TimePoint since_{};
  core::TimePoint port_seen_at_{};  ///< when the port was last there
  std::uint32_t outages_before_ = 0;
  std::uint32_t stops_before_ = 0;
  bool pilot_in_control_ = false;
  std::string_view reported_;  ///< problem; empty: there is none
};

}  // namespace m100::companion
