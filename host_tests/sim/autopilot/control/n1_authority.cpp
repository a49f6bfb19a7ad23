// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/control/n1_authority.h"

#include "protocol/dji/acks.h"

namespace m100::sim {

namespace ack = protocol::control_ack;

std::int16_t rc_mode(N1Mode mode) {
  switch (mode) {
    case N1Mode::kF:
      return protocol::kRcModeF;
    case N1Mode::kP:
      return protocol::kRcModeP;
    case N1Mode::kA:
      break;
  }
  return protocol::kRcModeA;
}

bool N1Authority::update_mode() {
  if (mode_ == wanted_mode_ || log_.now() < switch_ignored_until_) {
    return false;
  }
  mode_ = wanted_mode_;
  log_.emit("did", "mode", rc_mode(mode_));
  if (mode_ == N1Mode::kF) {
    if (lost_by_mode_ && how_.returns_with_mode_f) {
      lost_by_mode_ = false;
      device_ = protocol::ControlDevice::kOnboardComputer;
      log_.emit("did", "obtained");
    }
    return false;
  }
  requested_once_ = release_requested_once_ = false;
  lost_by_mode_ = lost_by_mode_ || client_in_control();
  return true;
}

std::uint16_t N1Authority::release() {
  if (!rc_in_f()) {
    return ack::kNotInModeF;  // the switch has already left F (protocol, section 11, state 8)
  }
  requested_once_ = false;  // after a release, control has to be requested twice again
  if (!client_in_control()) {
    return ack::kReleased;
  }
  release_requested_once_ = !release_requested_once_ && how_.requests_to_release > 1.0;
  if (release_requested_once_) {
    return ack::kReleasing;
  }
  device_ = protocol::ControlDevice::kRemoteController;
  lost_by_mode_ = false;
  return ack::kReleased;
}

std::uint16_t N1Authority::obtain() {
  release_requested_once_ = false;
  if (!rc_in_f()) {
    return ack::kNotInModeF;
  }
  if (ioc_) {
    return ack::kIocActive;
  }
  if (client_in_control()) {
    return ack::kObtained;
  }
  if (mobile_wants_control_) {
    return ack::kObtaining;  // for as long as the app has control
  }
  requested_once_ = !requested_once_ && how_.requests_to_obtain > 1.0;
  if (requested_once_) {
    return ack::kObtaining;
  }
  device_ = protocol::ControlDevice::kOnboardComputer;
  return ack::kObtained;
}

void N1Authority::drop(protocol::ControlDevice now_in_control) {
  device_ = now_in_control;
  requested_once_ = false;
}

void N1Authority::restart() {
  device_ = protocol::ControlDevice::kRemoteController;
  requested_once_ = release_requested_once_ = lost_by_mode_ = false;
}

}  // namespace m100::sim
