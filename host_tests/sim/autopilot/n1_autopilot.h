// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/core/time.h"
#include "hal/uart.h"
#include "host_tests/sim/autopilot/control/n1_controls.h"
#include "host_tests/sim/autopilot/n1_acknowledgements.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/autopilot/n1_client_record.h"
#include "host_tests/sim/autopilot/n1_event_log.h"
#include "host_tests/sim/autopilot/n1_line.h"
#include "host_tests/sim/autopilot/n1_script.h"
#include "host_tests/sim/autopilot/n1_telemetry.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/cipher.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

struct N1Config {
  std::uint32_t baud = 0;  ///< rate to pace the line to; 0: the UART paces itself
  std::uint64_t seed = 1;
  N1Mode mode = N1Mode::kF;                  ///< of the real mode switch
  const protocol::Cipher* cipher = nullptr;  ///< the app's key, for encrypted commands
  std::uint32_t app_id = 0;                  ///< the only app id that is activated; 0: any
  N1Rates rates = kAssistantRates;
  N1SensorNoise noise{};
  double clock_drift_ppm = 0.0;  ///< of its clock against ours; positive: its clock runs fast
  N1Behaviour behaviour{};
  /// The pilot flies while he has control: he brakes and holds the place. Otherwise his sticks stay at rest.
  bool pilot_holds_position = false;
  std::vector<N1ScriptLine> script{};
};

/// An emulated N1 autopilot (protocol, sections 4 to 8 and 11) that controls a vehicle.
///
/// Telemetry streams from the start in session 0, before activation. Acknowledgements have two bytes and are stored per
/// session; no command is executed twice. Control has to be requested twice (3, then 2) and is dropped when the switch
/// leaves F, with a push in session 0. Virtual RC ends one second after its last data; its data are distinguished from
/// its switch by their length. Movement without control is ignored. Inferred behaviour is marked (protocol, section
/// 11).
///
/// advance() handles the bytes that have arrived by then, in steps of 2.5 ms; call it as often as arrival times matter.
/// No heap after construction, if no event sink is set.
class N1Autopilot {
 public:
  static constexpr core::Duration kTick = N1Clock::kTick;
  static constexpr std::uint32_t kVersion = 0x03010A00;

  N1Autopilot(hal::Uart& uart, VehiclePort& vehicle, const N1Config& config);
  N1Autopilot(const N1Autopilot&) = delete;  // its parts refer to each other
  N1Autopilot& operator=(const N1Autopilot&) = delete;

  void advance(core::TimePoint now);
  /// The last and the next tick of its clock: the aircraft has moved up to the last, and moves again at the next.
  core::TimePoint ticked_at() const { return clock_.now(); }
  core::TimePoint ticks_next() const { return clock_.next(); }
  void on_event(std::function<void(const N1Event&)> sink) { log_.set_sink(std::move(sink)); }
  /// Sets a function that changes each package of telemetry before it is sent; empty: no change.
  void set_telemetry_fault(std::function<void(protocol::Telemetry&)> fault) { telemetry_.set_fault(std::move(fault)); }

  /// Has the same effect as a line of the script, immediately.
  void happen(N1EventKind what, double value = 0.0, N1Request request = N1Request::kAny);
  void happen(const N1ScriptLine& line);
  void set_mode(N1Mode mode) { happen(N1EventKind::kMode, static_cast<char>(mode)); }
  /// Resting position of the pilot's own sticks; flown while no other command is in force.
  void set_pilot_sticks(const StickInput& sticks) { controls_.transmitter().set_resting(sticks); }

  const N1Record& record() const { return record_.counts(); }
  bool activated() const { return activated_; }
  bool client_in_control() const { return controls_.authority().client_in_control(); }
  bool virtual_rc_on() const { return controls_.virtual_rc().is_on(); }
  /// Whether the pilot's own sticks fly: the controlling device is the transmitter, and Virtual RC does not replace it.
  bool transmitter_in_control() const { return controls_.transmitter_in_control(); }
  /// Since when the transmitter has control; the latest possible time while it has not.
  core::TimePoint transmitter_since() const { return controls_.transmitter().since(); }
  const protocol::ParserStats& parser_stats() const { return parser_.stats(); }
  /// Whether the script lets the source send poses, which are not part of an autopilot.
  bool pose_on() const { return pose_on_; }
  /// The active sensor fault, which the sender of the poses has to apply to them; null: none.
  SensorFaultInjector* fault_injector() { return telemetry_.fault_injector(); }
  /// Starts a sensor fault in telemetry and in the poses; replaces the one before.
  void start_sensor_fault(const SensorFault& fault, double size) { telemetry_.start_fault(fault, size); }

 private:
  void step(core::Duration passed);
  void receive();
  void handle(const protocol::FrameView& frame);
  /// @returns the code of the answer.
  std::uint16_t execute(const protocol::Command& command);
  void execute_unanswered(const protocol::Command& command, protocol::MessageId id);
  void refuse(const protocol::FrameHeader& header, const core::Expected<protocol::Message>& message);
  protocol::Value version_answer() const;
  std::uint16_t activate(const protocol::Activation& activation);
  void restart();
  void send_telemetry();

  VehiclePort& vehicle_;
  N1Config config_;
  N1Clock clock_;
  N1EventLog log_;
  N1Line line_;
  N1Acknowledgements acknowledgements_;
  N1ClientRecord record_;
  N1Controls controls_;
  N1Telemetry telemetry_;
  protocol::FrameParser parser_;
  protocol::CipherScratch scratch_{};
  std::size_t next_line_ = 0;  ///< of the script
  bool activated_ = false;
  std::uint16_t forced_activation_ = 0;  ///< the answer to an activation; 0: as it comes
  core::TimePoint off_until_{};
  bool pose_on_ = true;
};

}  // namespace m100::sim
