// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/probe/line_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <optional>

#include "firmware/app/sensor_adapter.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/preflight/board_checks.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/telemetry/telemetry_clock.h"
#include "hal/linux/serial_port.h"

namespace m100::companion {
namespace {

/// The rates to try, the usual one first (protocol, section 1).
constexpr std::array<std::uint32_t, 4> kBaudRates{230400, 921600, 115200, 460800};

constexpr double kBitsPerByte = 10.0;

/// Tries each requested baud rate until the autopilot or the source of pose is found, the port cannot be opened, or the
/// line is silent: a silent line stays silent at other rates.
void search_port(const std::string& port, std::uint32_t only, double seconds, std::optional<PortVerdict>& best) {
  for (const std::uint32_t baud : kBaudRates) {
    if (only != 0 && baud != only) {
      continue;
    }
    const PortVerdict finding = listen(port, baud, seconds);
    std::cout << printable(port) << " at " << baud << ": " << name(finding.verdict) << printable(holders_note(port))
              << std::endl;
    if (!best || rank(finding.verdict) < rank(best->verdict)) {
      best = finding;
    }
    if (finding.verdict == Verdict::kPosePort || finding.verdict == Verdict::kAutopilot ||
        finding.verdict == Verdict::kNothingReceived || finding.verdict == Verdict::kCannotOpen) {
      return;
    }
  }
}

/// @returns null if the port has no counters or was not opened.
Json to_json(const core::Expected<hal::LineErrors>& errors) {
  if (!errors) {
    return nullptr;
  }
  return {{"framing", errors->framing},
          {"parity", errors->parity},
          {"overrun", errors->overrun},
          {"breaks", errors->breaks}};
}

}  // namespace

PortVerdict listen(const std::string& path, std::uint32_t baud, double seconds) {
  PortVerdict finding{.port = path, .baud = baud};
  hal::SerialPort port(path, baud);
  if (port.open() != core::Status::kOk) {
    return finding;
  }
  hal::PortClock clock(path);
  LineProbe listener;
  link::LinkMeter meter(baud);
  std::array<std::byte, 1024> buffer;
  const core::TimePoint end{core::Duration{static_cast<std::int64_t>(seconds * 1e6)}};
  for (core::TimePoint now = clock.now(); now < end; now = clock.now()) {
    const std::uint64_t packages_before = listener.packages();
    const core::Expected<std::size_t> count = port.read(buffer);
    if (count && *count > 0) {
      meter.received(*count);
      listener.receive(std::span(buffer).first(*count));
    }
    for (std::uint64_t n = packages_before; n < listener.packages(); ++n) {
      meter.package(now);
    }
    if (listener.packages() > packages_before && listener.telemetry().has(protocol::TelemetryItem::kTime)) {
      const std::int64_t ticks = listener.telemetry().time.ticks;
      meter.timed_package(now, ticks * link::TelemetryClock::kTick);
    }
    meter.tick(now);
    clock.sleep_until(now + std::chrono::milliseconds(1));
  }
  meter.counters().parser = listener.stats();
  finding.errors = port.line_errors();
  finding.verdict = listener.verdict(finding.errors);
  finding.firmware = listener.firmware();
  finding.health = meter.health();
  finding.health.telemetry_rate_hz = static_cast<double>(listener.packages()) / seconds;
  finding.health.receive_share = static_cast<double>(listener.bytes()) * kBitsPerByte / baud / seconds;
  return finding;
}

PortVerdict search_line(const std::vector<std::string>& ports, std::uint32_t baud, double seconds) {
  std::optional<PortVerdict> best;
  for (const std::string& port : ports) {
    search_port(port, baud, seconds, best);
    if (best->verdict == Verdict::kAutopilot) {
      break;
    }
  }
  return *best;
}

std::string remedy_of(const PortVerdict& found) {
  if (found.verdict == Verdict::kCannotOpen) {
    const preflight::CheckResult port = preflight::check_port(found.port);
    return port.finding + ": " + port.remedy;
  }
  return std::string(remedy(found.verdict));
}

Json to_json(const PortVerdict& found) {
  return {{"port", found.port},
          {"baud", found.baud},
          {"verdict", name(found.verdict)},
          {"remedy", remedy_of(found)},
          {"line_errors", to_json(found.errors)},
          {"firmware", name(found.firmware)},
          {"health", companion::to_json(found.health)}};
}

std::string describe(const PortVerdict& found) {
  return std::to_string(found.baud) + " baud: " + std::string(name(found.verdict)) +
         (found.has_autopilot() ? ", " + std::string(name(found.firmware)) : "");
}

bool receive_telemetry(hal::Uart& port, LineProbe& line) {
  std::array<std::byte, 4096> buffer;
  const std::uint64_t before = line.packages();
  for (auto count = port.read(buffer); count && *count > 0; count = port.read(buffer)) {
    line.receive(std::span<const std::byte>(buffer).first(*count));
  }
  return line.packages() > before && line.has_attitude_and_force();
}

preflight::CheckResult missing_telemetry(const LineProbe& line, const char* name, preflight::Health health) {
  return line.packages() > 0 ? preflight::CheckResult{name, health, "telemetry without attitude or acceleration",
                                                      "set both items to 100 Hz in DJI's assistant"}
                             : preflight::CheckResult{name, health, "no telemetry came", "m100 probe tells why"};
}

namespace preflight {
namespace {

constexpr const char* kVibration = "vibration";
/// The high-passes begin with a step, the force itself: what they make of it is forgotten before the measurement.
constexpr double kSettle_s = 1.0, kMeasure_s = 3.0, kSettleMemory_s = 0.1;
constexpr int kFewest = 100;  ///< readings of the force, a third of what 100 Hz bring in kMeasure_s

CheckResult judge(const est::VibrationStatus& seen) {
  if (std::isnan(seen.rms_m_s2)) {
    return {kVibration, Health::kDoubtful, "not seen: telemetry comes at 30 Hz or less",
            "set acceleration to 100 Hz in DJI's assistant"};
  }
  const bool is_strong = seen.velocity_sigma_m_s >= kReportedVibration_m_s;
  return {kVibration, is_strong ? Health::kDoubtful : Health::kGood, std::string(describe_vibration(seen).text()),
          std::string(is_strong ? kVibrationRemedy : "")};
}

}  // namespace

CheckResult check_vibration(const std::string& path, std::uint32_t baud) {
  hal::SerialPort port(path, baud);
  if (port.open() != core::Status::kOk) {
    return {kVibration, Health::kDoubtful, "not measured, because the port does not open",
            "do what the port's line says"};
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
    return missing_telemetry(line, kVibration, Health::kDoubtful);
  }
  est::VibrationStatus seen = vibration.status(est::ForceConsistency<double>::kVelocityMemory_s);
  if (readings < kFewest) {
    seen.rms_m_s2 = std::numeric_limits<double>::quiet_NaN();
  }
  return judge(seen);
}

}  // namespace preflight

}  // namespace m100::companion
