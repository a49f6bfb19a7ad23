// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/protocol/every_message.h"

#include "protocol/aes256.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/pushes.h"

namespace m100::host_tests {
namespace {

const protocol::Cipher& cipher() {
  static const protocol::Aes256 instance(protocol::CipherKey{0x8F, 0x3D, 1, 2, 3, 4, 5});
  return instance;
}

class Collector {
 public:
  template <typename Message>
  void add(const std::string& name, std::uint8_t session, const Message& message) {
    const core::Expected<protocol::Value> value = encode(message);
    add_value(name, session, id_of(message), *value);
  }

  void add_ack(const std::string& name, const protocol::Value& value) {
    for (const bool encrypted : {false, true}) {
      frames_.push_back({(encrypted ? "encrypted " : "plain ") + name,
                         make_frame({.session = 2, .is_ack = true, .encrypted = encrypted, .sequence = next_++},
                                    nullptr, value, &cipher())});
    }
  }

  void add_value(const std::string& name, std::uint8_t session, protocol::MessageId id, const protocol::Value& value) {
    for (const bool encrypted : {false, true}) {
      frames_.push_back(
          {(encrypted ? "encrypted " : "plain ") + name,
           make_frame({.session = session, .encrypted = encrypted, .sequence = next_++}, &id, value, &cipher())});
    }
  }

  std::vector<NamedFrame> take() { return std::move(frames_); }

 private:
  std::vector<NamedFrame> frames_;
  std::uint16_t next_ = 60000;
};

protocol::MobileData mobile_data() {
  protocol::MobileData data;
  data.size = 12;
  data.bytes[0] = protocol::kStartByte;
  data.bytes[5] = std::byte{5};
  return data;
}

void add_commands(Collector& collect) {
  using namespace protocol;
  collect.add("version query", 2, VersionQuery{1});
  Activation activation{.app_id = 1030731, .api_level = 2, .version = 0x03010A00, .bundle_id = {}};
  activation.bundle_id.fill('9');
  collect.add("activation", 2, activation);
  TelemetryFrequency frequency;
  frequency.rates.fill(Rate::k100Hz);
  collect.add("frequency", 3, frequency);
  collect.add("to mobile", 4, ToMobile{mobile_data()});
  collect.add("obtain", 2, ControlRequest{true});
  collect.add("release", 2, ControlRequest{false});
  collect.add("task", 5, TaskRequest{42, Task::kLand});
  collect.add("task query", 6, TaskQuery{42});
  collect.add("arm", 7, MotorRequest{true});
  collect.add("movement", 0, Movement{.flag = 0x2A, .x = 3.25F, .y = -1.5F, .z = 38.75F, .yaw = 12.F});
  collect.add("gimbal rate", 0, GimbalRate{.yaw_decideg_s = 100, .roll_decideg_s = -5, .pitch_decideg_s = 1800});
  collect.add("gimbal angle", 0, GimbalAngle{.yaw_decideg = -3200, .roll_decideg = 1, .pitch_decideg = -900});
  collect.add("photo", 0, CameraRequest{CameraAction::kPhoto, 7});
  collect.add("video start", 0, CameraRequest{CameraAction::kVideoStart, 7});
  collect.add("video stop", 0, CameraRequest{CameraAction::kVideoStop, 7});
  collect.add("sync", 0, SyncPulse{10});
  collect.add("virtual rc on", 0, VirtualRcSwitch{.on = true, .fall_back_to_rc = true});
  VirtualRcData sticks;
  sticks.channels.fill(kStickCentre_counts);
  sticks.channels[vrc_channel::kMode] = kModeF_counts;
  collect.add("virtual rc data", 0, sticks);
}

void add_pushes(Collector& collect) {
  using namespace protocol;
  collect.add("control lost", 3, ControlLost{});
  collect.add("from mobile", 0, FromMobile{mobile_data()});
  collect.add("mission status", 0, MissionStatus{.kind = 1, .rest = {1, 2, 3, 4, 5}});
  collect.add("waypoint event", 0, WaypointEvent{.event = 2, .rest = {5, 4, 3, 2, 1}});
  Telemetry telemetry;
  telemetry.items = kAllTelemetryItems;
  telemetry.attitude = {0.5F, 0.5F, -0.5F, 0.5F};
  telemetry.rc.mode = kRcModeF;
  collect.add_value("telemetry", 0, ids::kTelemetry, encode(telemetry));
  telemetry.items = 0;
  collect.add_value("empty telemetry", 0, ids::kTelemetry, encode(telemetry));
}

}  // namespace

std::vector<NamedFrame> every_message() {
  Collector collect;
  add_commands(collect);
  add_pushes(collect);
  collect.add_ack("ack", protocol::encode_ack(protocol::control_ack::kObtained));
  protocol::VersionAnswer version{.code = protocol::kAckNotAuthorised, .version_crc = 0xA6453AAC};
  const std::string_view name = "SDK-v1.0 BETA M100-03.01.01.00";
  std::copy(name.begin(), name.end(), version.version_name.begin());
  collect.add_ack("version", encode(version));
  std::vector<NamedFrame> frames = collect.take();
  frames.push_back({"empty ack", make_frame({.session = 2, .is_ack = true}, nullptr, {})});
  return frames;
}

}  // namespace m100::host_tests
