// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "firmware/core/time.h"
#include "hal/uart.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/autopilot/n1_line.h"
#include "host_tests/sim/autopilot/n1_movement.h"
#include "host_tests/sim/autopilot/n1_pilot.h"
#include "host_tests/sim/autopilot/n1_script.h"
#include "host_tests/sim/autopilot/n1_telemetry.h"
#include "host_tests/sim/sensor_faults/sensor_fault_injector.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/cipher.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

enum class N1Mode : char { kF = 'F', kA = 'A', kP = 'P' };
std::int16_t rc_mode(N1Mode mode);  ///< value in the RC item of telemetry

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

/// One event. Names are those of the protocol's catalogue if there is one.
struct N1Event {
  core::TimePoint at{};
  std::string_view
      what;  ///< "received", "answered", "ignored", "did"; a breach is "received", with a "violation_" name
  std::string_view name;
  double value = 0.0;
};

/// Counters for a strict check of the client.
struct N1Record {
  std::uint32_t obtain_requests = 0;
  core::Duration min_obtain_spacing = core::Duration::max();
  std::uint32_t virtual_rc_on_requests = 0;
  core::Duration min_on_spacing = core::Duration::max();
  std::uint32_t movement_taken = 0;
  std::uint32_t movement_ignored = 0;
  std::uint32_t virtual_rc_taken = 0;
  std::uint32_t virtual_rc_ignored = 0;
  std::uint32_t max_commands_per_s = 0;  ///< of one channel, in any second
  std::uint32_t losses = 0;              ///< of authority while the client had it
  std::uint32_t control_after_loss = 0;  ///< control frames of a channel that arrived after the loss of authority
  core::Duration latest_after_loss{0};   ///< the longest time from the loss to such a frame
  std::uint32_t telemetry_packages = 0;
  std::uint32_t bad_commands = 0;  ///< wrong size, unknown, or a number that is not finite
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
  static constexpr core::Duration kTick = std::chrono::microseconds(2500);  ///< of its 400 Hz clock
  /// "On" sent sooner than this makes the autopilot ignore its own mode switch for a while (protocol, 7).
  static constexpr core::Duration kSwitchSpacing = std::chrono::seconds(2);
  static constexpr std::uint32_t kVersion = 0x03010A00;

  N1Autopilot(hal::Uart& uart, VehiclePort& vehicle, const N1Config& config);

  void advance(core::TimePoint now);
  /// The last and the next tick of its clock: the aircraft has moved up to the last, and moves again at the next.
  core::TimePoint ticked_at() const { return time_; }
  core::TimePoint ticks_next() const { return tick_time(ticks_ + 1); }
  void on_event(std::function<void(const N1Event&)> sink) { sink_ = std::move(sink); }
  /// Sets a function that changes each package of telemetry before it is sent; empty: no change.
  void set_telemetry_fault(std::function<void(protocol::Telemetry&)> fault) { telemetry_fault_ = std::move(fault); }

  /// Has the same effect as a line of the script, immediately.
  void happen(N1EventKind what, double value = 0.0, N1Request request = N1Request::kAny);
  void happen(const N1ScriptLine& line);
  void set_mode(N1Mode mode) { happen(N1EventKind::kMode, static_cast<char>(mode)); }
  /// Resting position of the pilot's own sticks; flown while no other command is in force.
  void set_pilot_sticks(const StickInput& sticks) {
    pilot_.set_resting(sticks);
    pilot_sticks_ = sticks;
  }

  const N1Record& record() const { return record_; }
  bool activated() const { return activated_; }
  bool client_in_control() const { return device_ == protocol::ControlDevice::kOnboardComputer; }
  bool virtual_rc_on() const { return virtual_rc_on_; }
  /// Whether the pilot's own sticks fly: the controlling device is the transmitter, and Virtual RC does not replace it.
  bool transmitter_in_control() const {
    return device_ == protocol::ControlDevice::kRemoteController && !virtual_rc_on_;
  }
  /// Since when the transmitter has control; the latest possible time while it has not.
  core::TimePoint transmitter_since() const { return transmitter_since_; }
  const protocol::ParserStats& parser_stats() const { return parser_.stats(); }
  /// Whether the script lets the room send poses, which are not part of an autopilot.
  bool pose_on() const { return pose_on_; }
  /// The active sensor fault, which the sender of the room's poses has to apply to them; null: none.
  SensorFaultInjector* fault_injector() { return fault_injector_ ? &*fault_injector_ : nullptr; }
  /// Starts a lie in telemetry and in the room's poses; replaces the function set by on_telemetry().
  void start_sensor_fault(const SensorFault& fault, double size) {
    fault_injector_.emplace(fault, size);
    set_telemetry_fault([this](protocol::Telemetry& telemetry) { fault_injector_->apply(telemetry); });
  }

 private:
  /// Times of the last commands of one channel, for the count in any second.
  class RateCounter {
   public:
    std::uint32_t count(core::TimePoint now);
    void clear() { count_ = 0; }

   private:
    static constexpr std::size_t kDepth = 256;
    std::array<core::TimePoint, kDepth> times_{};
    std::size_t count_ = 0;
  };

  core::TimePoint tick_time(std::int64_t tick) const;
  void step(core::Duration passed);
  void receive();
  void handle(const protocol::FrameView& frame);
  /// @returns the code of the answer.
  std::uint16_t execute(const protocol::Command& command);
  void execute_unanswered(const protocol::Command& command, protocol::MessageId id);
  void answer(const protocol::FrameHeader& to, std::span<const std::byte> value, const protocol::Cipher* cipher,
              N1Request request);
  void acknowledge(std::span<const std::byte> frame, N1Request request);
  bool loses_ack(N1Request request);
  void refuse(const protocol::FrameHeader& header, const core::Expected<protocol::Message>& message);
  protocol::Value version_answer() const;
  std::uint16_t activate(const protocol::Activation& activation);
  std::uint16_t set_rates(const protocol::TelemetryFrequency& wanted);
  std::uint16_t control(bool obtain);
  std::uint16_t motors(bool start);
  std::uint16_t start_task(const protocol::TaskRequest& request);
  std::uint16_t task_result(const protocol::TaskQuery& query) const;
  void switch_virtual_rc(const protocol::VirtualRcSwitch& wanted);
  void take_virtual_rc(const protocol::VirtualRcData& data);
  void take_movement(const protocol::Movement& movement);
  /// @param obeyed whether the channel is the client's. @returns the number of frames within the last second.
  std::uint32_t count_control_frame(RateCounter& watch, bool obeyed);

  void record_loss(bool client_commanded);
  void drop_control(std::string_view why, protocol::ControlDevice now_in_control);
  void take_control(bool mobile);
  void switch_rc(bool on);
  void end_virtual_rc(std::string_view why);
  void set_real_mode(N1Mode mode);
  void restart();
  bool rc_in_f() const { return rc_on_ && mode_ == N1Mode::kF; }
  void command_vehicle();
  void watch_transmitter();
  /// A task flies level, by the autopilot's own attitude hold [inferred], whoever has control of the sticks.
  MovementInput task_input();
  void end_task();
  /// Ends a task in progress if the pilot, or no device, has control [inferred].
  void end_task_with_control();
  StickInput virtual_sticks() const;
  MovementInput movement_input() const;
  void send_telemetry();
  protocol::Telemetry::Rc rc_item() const;
  protocol::FlightStatus flight_status() const;
  void push(protocol::MessageId id, std::span<const std::byte> value);
  void emit(std::string_view what, std::string_view name, double value = 0.0) const;

  VehiclePort& vehicle_;
  N1Config config_;
  N1Line line_;
  Random random_;
  std::function<void(const N1Event&)> sink_;
  std::function<void(protocol::Telemetry&)> telemetry_fault_;
  protocol::FrameParser parser_;
  protocol::CipherScratch scratch_{};
  protocol::AnswerSessions sessions_;
  N1Record record_;
  core::TimePoint time_{};  ///< ours
  std::int64_t ticks_ = 0;  ///< of its own clock
  N1Estimator estimator_;
  std::size_t next_line_ = 0;  ///< of the script

  // State that a restart resets.
  std::int64_t booted_at_tick_ = 0;
  bool activated_ = false;
  protocol::ControlDevice device_ = protocol::ControlDevice::kRemoteController;
  bool requested_once_ = false;
  bool release_requested_once_ = false;
  bool lost_by_mode_ = false;  ///< the client had control when the switch left F
  bool virtual_rc_on_ = false;
  bool virtual_rc_falls_back_ = true;
  core::TimePoint last_virtual_rc_{};
  protocol::VirtualRcData virtual_rc_;
  bool moving_ = false;
  core::TimePoint last_movement_{};
  N1Movement movement_;
  protocol::Task task_{};
  bool task_open_ = false;
  bool task_done_ = false;
  std::uint8_t task_number_ = 0;
  core::TimePoint landed_at_{};  ///< when a task landed; the epoch: never
  std::uint16_t push_sequence_ = 0;

  // The world around it.
  N1Mode mode_;
  bool rc_on_ = true;
  bool ioc_ = false;
  double tasks_ = 1.0;  ///< value of N1EventKind::kTasks
  bool pose_on_ = true;
  std::optional<SensorFaultInjector> fault_injector_;
  bool mobile_wants_control_ = false;
  core::TimePoint switch_ignored_until_{};
  N1Mode wanted_mode_;
  N1Pilot pilot_;
  StickInput pilot_sticks_;
  core::TimePoint transmitter_since_{};
  N1Rates rates_;
  std::uint64_t slot_ = 0;
  std::uint16_t forced_activation_ = 0;
  std::uint32_t acks_to_lose_ = 0;
  N1Request acks_to_lose_of_ = N1Request::kAny;
  /// The request that each session's stored answer belongs to.
  std::array<N1Request, protocol::kSessionCount> request_in_session_{};
  std::uint32_t acks_to_double_ = 0;
  core::Duration ack_delay_{0};
  core::TimePoint silent_until_{};
  core::TimePoint off_until_{};
  core::TimePoint last_obtain_{};
  core::TimePoint last_on_{};
  bool authority_lost_ = false;
  core::TimePoint lost_at_{};
  RateCounter movement_watch_;
  RateCounter virtual_rc_watch_;
};

}  // namespace m100::sim
