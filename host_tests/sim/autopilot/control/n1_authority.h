// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/autopilot/n1_event_log.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

enum class N1Mode : char { kF = 'F', kA = 'A', kP = 'P' };
std::int16_t rc_mode(N1Mode mode);  ///< value in the RC item of telemetry

/// Which device has control, and what decides it: the remote controller with its mode switch, the mobile app, and the
/// client's requests. Control has to be requested twice (3, then 2), and so has its release, if `how` says no other.
class N1Authority {
 public:
  N1Authority(const N1EventLog& log, const N1Behaviour::Control& how, N1Mode mode)
      : log_(log), how_(how), mode_(mode), wanted_mode_(mode) {}

  N1Mode mode() const { return mode_; }
  /// Position of the mode switch, even if the autopilot ignores it.
  N1Mode wanted_mode() const { return wanted_mode_; }
  void set_wanted_mode(N1Mode mode) { wanted_mode_ = mode; }
  void ignore_switch_until(core::TimePoint until) { switch_ignored_until_ = until; }
  /// Follows the mode switch unless it is ignored; control may return with F. @returns whether the mode changed to
  /// another than F.
  bool update_mode();
  bool rc_in_f() const { return rc_on_ && mode_ == N1Mode::kF; }
  bool rc_is_on() const { return rc_on_; }
  void switch_rc(bool on) { rc_on_ = on; }
  void set_ioc(bool on) { ioc_ = on; }
  void set_mobile_wants_control(bool wants) { mobile_wants_control_ = wants; }

  protocol::ControlDevice device() const { return device_; }
  bool client_in_control() const { return device_ == protocol::ControlDevice::kOnboardComputer; }
  /// Whether telemetry shows that the client has control or is about to.
  bool client_requested() const { return client_in_control() || requested_once_; }
  /// The client's requests. @returns the code of the answer.
  std::uint16_t obtain();
  std::uint16_t release();
  /// Takes control from the client, or keeps it from it. The request begins anew.
  void drop(protocol::ControlDevice now_in_control);
  void restart();

 private:
  const N1EventLog& log_;
  const N1Behaviour::Control& how_;
  N1Mode mode_;
  N1Mode wanted_mode_;
  core::TimePoint switch_ignored_until_{};
  bool rc_on_ = true;
  bool ioc_ = false;
  bool mobile_wants_control_ = false;
  protocol::ControlDevice device_ = protocol::ControlDevice::kRemoteController;
  bool requested_once_ = false;
  bool release_requested_once_ = false;
  bool lost_by_mode_ = false;  ///< the client had control when the switch left F
};

}  // namespace m100::sim
