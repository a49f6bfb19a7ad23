// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/frames/telemetry_json.h"

namespace m100::lab {
namespace {

using protocol::Telemetry;
using protocol::TelemetryItem;

unsigned bit(unsigned bits, unsigned index) { return (bits >> index) & 1U; }

void add_motion(Json& fields, const Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kTime)) {
    fields["time_ticks"] = telemetry.time.ticks;
    fields["time_ns"] = telemetry.time.nanoseconds;
    fields["sync_flag"] = telemetry.time.sync;
  }
  if (telemetry.has(TelemetryItem::kAttitude)) {
    fields["q"] = telemetry.attitude;
  }
  if (telemetry.has(TelemetryItem::kAcceleration)) {
    fields["acc"] = telemetry.acceleration;
  }
  if (telemetry.has(TelemetryItem::kVelocity)) {
    fields["vel_mps"] = telemetry.velocity_ned_m_s;
    fields["vel_health"] = telemetry.velocity_status & 1U;
    fields["vel_sensor_id"] = (telemetry.velocity_status >> 1U) & 15U;
    fields["vel_reserved"] = telemetry.velocity_status >> 5U;
  }
  if (telemetry.has(TelemetryItem::kAngularVelocity)) {
    fields["gyro_rad_s"] = telemetry.angular_velocity_frd_rad_s;
  }
  if (telemetry.has(TelemetryItem::kPosition)) {
    fields["lat_rad"] = telemetry.position.latitude_rad;
    fields["lon_rad"] = telemetry.position.longitude_rad;
    fields["alt_m"] = telemetry.position.altitude_m;
    fields["height_m"] = telemetry.position.height_m;
    fields["gps_health"] = telemetry.position.gps_health;
  }
}

void add_state(Json& fields, const Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kMagnetometer)) {
    fields["mag"] = telemetry.magnetometer;
  }
  if (telemetry.has(TelemetryItem::kRc)) {
    const Telemetry::Rc& rc = telemetry.rc;
    fields["rc"] = {{"roll", rc.roll},         {"pitch", rc.pitch}, {"yaw", rc.yaw},
                    {"throttle", rc.throttle}, {"mode", rc.mode},   {"gear", rc.gear}};
  }
  if (telemetry.has(TelemetryItem::kGimbal)) {
    const Telemetry::Gimbal& gimbal = telemetry.gimbal;
    fields["gimbal_deg"] = {{"roll", gimbal.roll_deg}, {"pitch", gimbal.pitch_deg}, {"yaw", gimbal.yaw_deg}};
    fields["gimbal_limit"] = {
        {"pitch", bit(gimbal.limits, 0)}, {"roll", bit(gimbal.limits, 1)}, {"yaw", bit(gimbal.limits, 2)}};
    fields["gimbal_reserved"] = gimbal.limits >> 3U;
  }
  if (telemetry.has(TelemetryItem::kFlightStatus)) {
    fields["flight_status"] = static_cast<unsigned>(telemetry.flight_status);
  }
  if (telemetry.has(TelemetryItem::kBattery)) {
    fields["battery_pct"] = telemetry.battery_percent;
  }
  if (telemetry.has(TelemetryItem::kControl)) {
    const Telemetry::Control& control = telemetry.control;
    fields["control"] = {{"mode", control.mode},
                         {"device", control.bits & 7U},
                         {"sdk_requested", bit(control.bits, 3)},
                         {"vrc_enabled", bit(control.bits, 4)},
                         {"reserved", control.bits >> 5U}};
  }
}

}  // namespace

Json telemetry_fields(const Telemetry& telemetry) {
  Json fields{{"enable_flag", telemetry.items}};
  add_motion(fields, telemetry);
  add_state(fields, telemetry);
  return fields;
}

}  // namespace m100::lab
