// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/probe/vibration_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/app/sensor_adapter.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/preflight/probe/line_check.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion::preflight {
namespace {

constexpr const char* kName = "vibration";
/// The high-passes begin with a step, the force itself: what they make of it is forgotten before the measurement.
constexpr double kSettle_s = 1.0, kMeasure_s = 3.0, kSettleMemory_s = 0.1;
constexpr int kFewest = 100;  ///< readings of the force, a third of what 100 Hz bring in kMeasure_s

CheckResult judge(const est::VibrationStatus& seen) {
  if (std::isnan(seen.rms_m_s2)) {
    return {kName, Health::kDoubtful, "not seen: telemetry comes at 30 Hz or less",
            "set acceleration to 100 Hz in DJI's assistant"};
  }
  const bool is_strong = seen.velocity_sigma_m_s >= kReportedVibration_m_s;
  TextLine finding;
  describe_vibration(finding, seen);
  return {kName, is_strong ? Health::kDoubtful : Health::kGood, std::string(finding.text()),
          std::string(is_strong ? kVibrationRemedy : "")};
}

}  // namespace

CheckResult check_vibration(const std::string& path, std::uint32_t baud) {
  hal::SerialPort port(path, baud);
  if (port.open() != core::Status::kOk) {
    return {kName, Health::kDoubtful, "not measured, because the port does not open", "do what the port's line says"};
  }
  LineProbe line;
  app::SensorAdapter adapter;
  est::SpecificForce<double> force;
  est::Vibration<double> vibration;
  core::TimePoint former{};
  int readings = 0;
  TickClock clock(path);
  for (core::TimePoint now = clock.now(); core::seconds<double>(now.time_since_epoch()) < kSettle_s + kMeasure_s;
       now = clock.next()) {
    if (!receive_telemetry(port, line)) {
      continue;
    }
    const protocol::Telemetry& telemetry = line.telemetry();
    const est::ImuSample<double> imu = app::SensorAdapter::imu_sample(
        telemetry, adapter.update<double>(telemetry, core::Duration{0}, core::Pose<double>{}, {}, now));
    force.update(imu);
    vibration.update(
        force.raw_m_s2(), imu.force_b.cwiseAbs().maxCoeff() * force.scale_m_s2(), core::seconds<double>(now - former),
        std::clamp(core::seconds<double>(now.time_since_epoch()) - kSettle_s, kSettleMemory_s, kMeasure_s));
    former = now;
    readings += force.scale_m_s2() > 0.0 ? 1 : 0;
  }
  if (!line.has_attitude_and_force()) {
    return missing_telemetry(line, kName, Health::kDoubtful);
  }
  est::VibrationStatus seen = vibration.status(est::ForceConsistency<double>::kVelocityMemory_s);
  if (readings < kFewest) {
    seen.rms_m_s2 = std::numeric_limits<double>::quiet_NaN();
  }
  return judge(seen);
}

}  // namespace m100::companion::preflight
