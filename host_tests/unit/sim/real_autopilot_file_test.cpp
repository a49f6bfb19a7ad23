// SPDX-License-Identifier: BSD-3-Clause
// Each key of the file changes what a client or the aircraft sees of the emulated autopilot.
#include "host_tests/sim/autopilot/real_autopilot_file.h"

#include <fstream>
#include <set>
#include <sstream>

#include "host_tests/refusal.h"
#include "host_tests/unit/sim/n1_fixture.h"
#include "protocol/aes256.h"

namespace m100::sim {
namespace {

using Channels = std::array<std::uint32_t, 4>;

class Bench : public N1Test {
 public:
  void TestBody() override {}
  explicit Bench(const std::string& file) {
    config.behaviour = parse_real_autopilot(file, "real.toml");
    start(config);
  }

  double answer_to_obtain() { return code(ids::kControlRequest, bytes({1})); }
  double device() {
    fast_rates();
    return static_cast<unsigned>(last_control().control.bits) & 7U;
  }
  double telemetry_in(core::Duration time) {
    heard.clear();
    run(time);
    return static_cast<double>(pushes(ids::kTelemetry));
  }
  void leave_mode(N1Mode mode) {
    autopilot->set_mode(mode);
    run(milliseconds(20));
  }
  void in_control() {
    activate();
    for (int request = 0; request < 2 && !autopilot->client_in_control(); ++request) {
      code(ids::kControlRequest, bytes({1}));
    }
  }
  void switch_virtual_rc() {
    send(ids::kVirtualRcSwitch, bytes({3}));
    run(milliseconds(20));
  }
  void stick(const Channels& first, protocol::MessageId id = ids::kVirtualRcData) {
    protocol::VirtualRcData data;
    data.channels.fill(1024);
    std::copy(first.begin(), first.end(), data.channels.begin());
    data.channels[protocol::vrc_channel::kGear] = 1324;
    const auto value = encode(data);
    send(id, {value->bytes().begin(), value->bytes().end()});
    run(milliseconds(20));
  }
  StickInput flown_sticks(const Channels& first) {
    activate();
    switch_virtual_rc();
    stick(first);
    return std::get<StickInput>(vehicle.last_input());
  }
  void move(float x, float y, float z, float yaw) {
    const auto value = encode(protocol::Movement{.flag = 0x0A, .x = x, .y = y, .z = z, .yaw = yaw});
    send(ids::kMovement, {value->bytes().begin(), value->bytes().end()});
    run(milliseconds(20));
  }
  MovementInput flown_movement() {
    in_control();
    move(10.F, -20.F, 1.F, 30.F);
    return std::get<MovementInput>(vehicle.last_input());
  }
  /// The climb that the aircraft is given; 0 also when it follows the pilot's sticks.
  double climb() const {
    const auto* const input = std::get_if<MovementInput>(&vehicle.last_input());
    return input == nullptr ? 0.0 : input->climb_m_s;
  }
  /// @returns the answer.
  double take_off() {
    vehicle.mutable_state().in_air = vehicle.mutable_state().motors_on = false;
    vehicle.mutable_state().position_w_m.z() = 1.0;
    in_control();
    const double answer = code(ids::kTask, bytes({1, 4}));
    run(milliseconds(20));
    return answer;
  }

  N1Config config;
};

/// What is seen of the autopilot as assumed and, with the key, as the file says.
struct Seen {
  const char* key;
  const char* value;
  double assumed, real;
  double (*see)(Bench&);
};

const Seen kSeen[]{
    {"answers.delay_s", "0.2", 1, 0,
     [](Bench& n1) { return n1.ask(ids::kVersionQuery, bytes({0})).has_value() ? 1.0 : 0.0; }},
    {"answers.needs_activation", "false", 0xFF01, 3, [](Bench& n1) { return n1.answer_to_obtain(); }},
    {"answers.wrong_key_in_plain", "false", 1, 0,
     [](Bench& n1) {
       static const protocol::Aes256 kRight(protocol::CipherKey{1}), kWrong(protocol::CipherKey{9});
       n1.config.cipher = &kRight;
       n1.start(n1.config);
       n1.activate();
       n1.cipher_of_client = &kWrong;
       return n1.ask(ids::kControlRequest, bytes({1}), 3, &kWrong).has_value() ? 1.0 : 0.0;
     }},
    {"control.requests_to_obtain", "1", 3, 2,
     [](Bench& n1) {
       n1.activate();
       return n1.answer_to_obtain();
     }},
    {"control.requests_to_release", "1", 4, 1,
     [](Bench& n1) {
       n1.in_control();
       return double(n1.code(ids::kControlRequest, bytes({0})));
     }},
    {"control.lost_push", "false", 1, 0,
     [](Bench& n1) {
       n1.in_control();
       n1.heard.clear();
       n1.leave_mode(N1Mode::kA);
       return double(n1.pushes(ids::kControlLost));
     }},
    {"control.returns_with_mode_f", "true", 0, 2,
     [](Bench& n1) {
       n1.in_control();
       n1.leave_mode(N1Mode::kA);
       n1.leave_mode(N1Mode::kF);
       return n1.device();
     }},
    {"virtual_rc.timeout_s", "0.2", 1, 0,
     [](Bench& n1) {
       n1.activate();
       n1.switch_virtual_rc();
       n1.run(milliseconds(500));
       return n1.autopilot->virtual_rc_on() ? 1.0 : 0.0;
     }},
    {"virtual_rc.needs_control", "true", 1100, 1024,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1024, 1024, 1024}).roll_vrc;
     }},
    {"virtual_rc.end_gives_control_back", "true", 2, 0,
     [](Bench& n1) {
       n1.in_control();
       n1.switch_virtual_rc();
       n1.run(milliseconds(1200));
       return n1.device();
     }},
    {"virtual_rc.leaving_f_ends_it", "false", 1024, 1100,
     [](Bench& n1) {
       n1.flown_sticks({1100, 1024, 1024, 1024});
       n1.leave_mode(N1Mode::kA);
       return std::get<StickInput>(n1.vehicle.last_input()).roll_vrc;
     }},
    {"virtual_rc.shown_in_rc_item", "false", protocol::kRcModeA, protocol::kRcModeF,
     [](Bench& n1) {
       n1.activate();
       n1.fast_rates();
       n1.switch_virtual_rc();
       return double(n1.last_control().rc.mode);
     }},
    {"virtual_rc.data_under_switch_id", "true", 1024, 1100,
     [](Bench& n1) {
       n1.activate();
       n1.switch_virtual_rc();
       n1.stick({1100, 1024, 1024, 1024}, ids::kVirtualRcSwitch);
       return std::get<StickInput>(n1.vehicle.last_input()).roll_vrc;
     }},
    {"virtual_rc.full_deflection_counts", "330", 1100, 1176,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1024, 1024, 1024}).roll_vrc;
     }},
    {"virtual_rc.roll_sign", "-1", 1100, 948,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1050, 1060, 1070}).roll_vrc;
     }},
    {"virtual_rc.pitch_sign", "-1", 1050, 998,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1050, 1060, 1070}).pitch_vrc;
     }},
    {"virtual_rc.throttle_sign", "-1", 1060, 988,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1050, 1060, 1070}).throttle_vrc;
     }},
    {"virtual_rc.yaw_sign", "-1", 1070, 978,
     [](Bench& n1) {
       return n1.flown_sticks({1100, 1050, 1060, 1070}).yaw_vrc;
     }},
    {"movement.timeout_s", "60", 0, 1,
     [](Bench& n1) {
       n1.flown_movement();
       n1.run(seconds(1));
       return n1.climb();
     }},
    {"movement.timeout_gives_control_back", "true", 2, 0,
     [](Bench& n1) {
       n1.flown_movement();
       n1.run(seconds(1));
       return n1.device();
     }},
    {"movement.roll_sign", "-1", 0.17453, -0.17453, [](Bench& n1) { return n1.flown_movement().roll_rad; }},
    {"movement.pitch_sign", "-1", 0.34907, -0.34907, [](Bench& n1) { return n1.flown_movement().pitch_rad; }},
    {"movement.climb_sign", "-1", 1, -1, [](Bench& n1) { return n1.flown_movement().climb_m_s; }},
    {"movement.yaw_sign", "-1", -0.5236, 0.5236, [](Bench& n1) { return n1.flown_movement().yaw_rate_rad_s; }},
    {"tasks.offered", "false", 2, 1, [](Bench& n1) { return n1.take_off(); }},
    {"tasks.end_with_control", "false", 0, 0.8,
     [](Bench& n1) {
       n1.take_off();
       n1.leave_mode(N1Mode::kA);
       return n1.climb();
     }},
    {"tasks.take_off_height_m", "0.9", 0.8, 0,
     [](Bench& n1) {
       n1.take_off();
       return n1.climb();
     }},
    {"tasks.take_off_climb_m_s", "0.4", 0.8, 0.4,
     [](Bench& n1) {
       n1.take_off();
       return n1.climb();
     }},
    {"tasks.landing_sink_m_s", "0.3", -0.5, -0.3,
     [](Bench& n1) {
       n1.in_control();
       n1.code(ids::kTask, bytes({1, 6}));
       n1.run(milliseconds(20));
       return n1.climb();
     }},
    {"telemetry.before_activation", "false", 50, 0, [](Bench& n1) { return n1.telemetry_in(milliseconds(1005)); }},
    {"telemetry.rate_hz", "10", 50, 10, [](Bench& n1) { return n1.telemetry_in(milliseconds(1005)); }},
    {"telemetry.obeys_rates", "false", 10, 50,
     [](Bench& n1) {
       n1.activate();
       n1.code(ids::kTelemetryFrequency, bytes({2, 2, 2, 2, 2, 2, 0, 2, 0, 2, 2, 2, 0, 0, 0, 0}));
       return n1.telemetry_in(milliseconds(1005));
     }},
    {"telemetry.acceleration_unit_m_s2", "1", -1, -9.8066,
     [](Bench& n1) {
       n1.activate();
       n1.fast_rates();
       return double(n1.last_control().acceleration[2]);
     }},
    {"telemetry.silent_after_restart_s", "0.5", 0, 1,
     [](Bench& n1) {
       n1.autopilot->happen(N1EventKind::kRestart);
       return n1.telemetry_in(seconds(1)) > 0 ? 1.0 : 0.0;
     }},
};

std::string line_of(const std::string& key, const std::string& value) {
  const std::size_t dot = key.find('.');
  return "[" + key.substr(0, dot) + "]\n" + key.substr(dot + 1) + " = " + value + "\n";
}

std::string refusal_of(const std::string& text) {
  return host_tests::refusal_by<companion::FileError>([&] { parse_real_autopilot(text, "real.toml"); });
}

TEST(RealAutopilotFile, EachKeyChangesWhatIsSeen) {
  constexpr double kRounding = 1e-4;
  for (const Seen& row : kSeen) {
    Bench assumed(""), real(line_of(row.key, row.value));
    EXPECT_NEAR(row.see(assumed), row.assumed, kRounding) << row.key;
    EXPECT_NEAR(row.see(real), row.real, kRounding) << row.key << " = " << row.value;
  }
}

TEST(RealAutopilotFile, EveryKeyIsTriedHereAndStandsOnTheCard) {
  std::ostringstream card;
  card << std::ifstream(M100_FIRST_CONTACT).rdbuf();
  std::set<std::string> tried;
  for (const Seen& row : kSeen) {
    tried.insert(row.key);
  }
  for (const RealAutopilotKey& key : real_autopilot_keys()) {
    const std::string full = std::string(key.section) + "." + std::string(key.key);
    EXPECT_EQ(tried.count(full), 1U) << full;
    EXPECT_NE(card.str().find("`" + full + "`"), std::string::npos) << full << " is not on the card";
  }
  EXPECT_EQ(tried.size(), real_autopilot_keys().size());
}

TEST(RealAutopilotFile, RefusesWhatItDoesNotKnowByLineAndKey) {
  EXPECT_EQ(refusal_of("[movement]\ntimeout = 1\n"),
            "real.toml:2: 'movement.timeout': unknown key; did you mean `timeout_s`?");
  EXPECT_EQ(refusal_of("[movment]\n"), "real.toml:1: 'movment': unknown section; did you mean `movement`?");
  EXPECT_EQ(refusal_of("[control]\nrequests_to_obtain = 3\n"),
            "real.toml:2: 'control.requests_to_obtain': must be 1 or 2");
  EXPECT_EQ(refusal_of("[tasks]\noffered = 1\n"), "real.toml:2: 'tasks.offered': must be true or false");
  EXPECT_EQ(refusal_of("[answers]\ndelay_s = -1\n"), "real.toml:2: 'answers.delay_s': must be a number from 0 to 10");
  EXPECT_EQ(refusal_of("tasks = 1\n"), "real.toml:1: 'tasks': must be a table");
}

}  // namespace
}  // namespace m100::sim
