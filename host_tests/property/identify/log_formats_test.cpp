// SPDX-License-Identifier: BSD-3-Clause
// One simulated flight, written in PX4's log dialect and in our own, must give the same answer.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/logs/proposal/propose.h"
#include "host_tests/own_folder.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"
#include "host_tests/unit/logs/ulog_bytes.h"

namespace m100::host_tests {
namespace {

using lab::logs::FlightLog;
using lab::logs::Signal;
using lab::logs::UlogBytes;

constexpr double kPowerOn_s = 123.4;

std::uint64_t stamp_us(std::size_t k) {
  return static_cast<std::uint64_t>(std::llround(1e6 * (kPowerOn_s + 0.01 * static_cast<double>(k))));
}

std::string raw(double value) { return UlogBytes::raw(static_cast<float>(value)); }

/// Writes the flight as PX4 does: body and world frames with z down, attitude as a quaternion whose sign may change,
/// separate topics with separate clocks, padding inside the formats and none at the end of messages.
std::string px4(const FlightLog& flight, double gain_rad) {
  UlogBytes log;
  log.message('B', std::string(40, '\0'));
  log.message('F', "vehicle_attitude:uint64_t timestamp;float[4] q;uint8_t quat_reset_counter;uint8_t[7] _padding0;");
  log.message('F',
              "vehicle_attitude_setpoint:uint64_t timestamp;float roll_body;float pitch_body;bool q_d_valid;"
              "uint8_t[7] _padding0;");
  log.subscribe(0, 3, "vehicle_attitude");
  log.subscribe(0, 5, "vehicle_attitude_setpoint");
  for (std::size_t k = 0; k < flight.size; ++k) {
    const double half = 0.5 * flight.of(Signal::kAttitudeRoll)[k];
    const double sign = (k / 37) % 2 == 0 ? 1.0 : -1.0;
    log.data(5, UlogBytes::raw(stamp_us(k)) + raw(gain_rad * flight.of(Signal::kStickRoll)[k]) +
                    raw(-gain_rad * flight.of(Signal::kStickPitch)[k]) + '\1');
    // Heading 90 degrees to the right in PX4's frame: turn about z first, then roll.
    const double c = std::sqrt(0.5);
    log.data(3, UlogBytes::raw(stamp_us(k)) + raw(sign * c * std::cos(half)) + raw(sign * c * std::sin(half)) +
                    raw(sign * c * std::sin(half)) + raw(sign * c * std::cos(half)) + '\0');
  }
  return log.bytes();
}

std::string own(const FlightLog& flight) {
  UlogBytes log;
  log.message('F',
              "tick:uint64_t timestamp;uint16_t[4] sticks;double[3] imu_attitude;double[3] imu_rate;"
              "double[3] pose_position;double[3] velocity;float pose_age;");
  log.subscribe(0, 0, "tick");
  for (std::size_t k = 0; k < flight.size; ++k) {
    const auto stick = [&](Signal signal) {
      return UlogBytes::raw(static_cast<std::uint16_t>(std::lround(1024.0 + flight.of(signal)[k])));
    };
    log.data(0, UlogBytes::raw(stamp_us(k)) + stick(Signal::kStickRoll) + stick(Signal::kStickPitch) +
                    std::string("\0\4\0\4", 4) + UlogBytes::raw(flight.of(Signal::kAttitudeRoll)[k]) +
                    std::string(11 * sizeof(double) + sizeof(float), '\0'));
  }
  return log.bytes();
}

lab::identify::IdentifyResult identified(const std::string& name, const std::string& bytes, std::string& dialect) {
  const auto raw_log = lab::logs::open_log(made(name + ".ulg", bytes));
  const auto proposal = lab::logs::propose(*raw_log);
  dialect = proposal ? proposal->dialect : "";
  const FlightLog log =
      lab::logs::load(*raw_log, lab::logs::parse_column_map(proposal ? proposal->toml : "", "proposed"));
  EXPECT_NEAR(log.start_s, kPowerOn_s, 1e-6) << "the clock of the log must be kept";
  return lab::identify::identify_axis(lab::identify::about(log, "roll", {"second_order", "transport_delay"},
                                                           {kPowerOn_s + 3.0, kPowerOn_s + 30.0},
                                                           {kPowerOn_s + 30.0, kPowerOn_s + 44.0}));
}

TEST(Dialects, ThePx4LogIsIdentifiedLikeOurOwn) {
  SyntheticAxis vehicle;
  vehicle.hidden = {{"gain_asymmetry", 1.3}};
  const FlightLog flight = vehicle.fly();
  std::string dialect;
  const auto ours = identified("own", own(flight), dialect);
  EXPECT_EQ(dialect, "our own flight log");
  const auto theirs = identified("px4", px4(flight, vehicle.gain_rad), dialect);
  EXPECT_EQ(dialect, "PX4");

  EXPECT_EQ(theirs.verdict, ours.verdict);
  ASSERT_EQ(theirs.final_model.structure, ours.final_model.structure);
  ASSERT_EQ(ours.effects.size(), 1U);
  EXPECT_EQ(ours.effects[0].name, "gain_asymmetry");
  // Tolerance: single precision of angle and set point is 1e-7, far below the air's 0.004 rad, and the search stops at
  // 1e-3 of a parameter. Gain and trim are of counts in one log and of radians in the
  // other.
  for (std::size_t i = 0; i < ours.final_model.parameters.size(); ++i) {
    const auto& mine = ours.final_model.parameters[i];
    const double unit = mine.name.find("scale") == 0 || mine.name == "gain" ? 1.0 / vehicle.gain_rad
                        : mine.name == "offset_counts"                      ? vehicle.gain_rad
                                                                            : 1.0;
    EXPECT_NEAR(theirs.final_model.parameters[i].value, unit * mine.value, 2e-3 * std::abs(unit * mine.value) + 1e-5)
        << mine.name;
  }
  EXPECT_NEAR(theirs.final_model.validation_rmse, ours.final_model.validation_rmse,
              1e-3 * ours.final_model.validation_rmse);
}

}  // namespace
}  // namespace m100::host_tests
