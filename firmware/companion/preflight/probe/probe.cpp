// SPDX-License-Identifier: BSD-3-Clause
// m100 probe: listens only; finds the device at the other end, its baud rate, and what is wrong.
#include "firmware/companion/preflight/probe/probe.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/board_checks.h"
#include "firmware/companion/preflight/probe/line_probe.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/telemetry/telemetry_clock.h"
#include "hal/linux/serial_port.h"

namespace m100::companion {
namespace {

/// The rates to try, the usual one first (protocol, section 1).
constexpr std::array<std::uint32_t, 4> kBaudRates{230400, 921600, 115200, 460800};

constexpr double kBitsPerByte = 10.0;

struct ProbeOptions {
  std::string port;
  std::uint32_t baud = 0;
  double seconds = 2.0;
  std::string json;
};

struct PortVerdict {
  std::string port;
  std::uint32_t baud = 0;
  Verdict verdict = Verdict::kCannotOpen;
  Firmware firmware = Firmware::kUnknown;
  link::LinkHealth health;
  core::Expected<hal::LineErrors> errors = core::Status::kUnavailable;
};

PortVerdict listen(const std::string& path, std::uint32_t baud, double seconds) {
  PortVerdict finding{.port = path,
                      .baud = baud,
                      .verdict = Verdict::kCannotOpen,
                      .firmware = {},
                      .health = {},
                      .errors = core::Status::kUnavailable};
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

/// Better findings have lower ranks: understood frames before mere bytes.
int rank(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAutopilot:
      return 0;
    case Verdict::kNoisy:
    case Verdict::kOverrun:
      return 1;
    case Verdict::kApiNotEnabled:
    case Verdict::kPosePort:
      return 2;
    case Verdict::kNoAutopilot:
    case Verdict::kWrongBaud:
      return 3;
    case Verdict::kLineHeldLow:
    case Verdict::kNothingReceived:
      return 4;
    case Verdict::kCannotOpen:
      break;
  }
  return 5;
}

/// Tries each requested baud rate until the autopilot or the source of pose is found, the port cannot be opened, or the
/// line is silent: a silent line stays silent at other rates.
void search_port(const std::string& port, const ProbeOptions& options, std::optional<PortVerdict>& best) {
  for (const std::uint32_t baud : kBaudRates) {
    if (options.baud != 0 && baud != options.baud) {
      continue;
    }
    const PortVerdict finding = listen(port, baud, options.seconds);
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

PortVerdict search(const ProbeOptions& options) {
  if (std::isnan(options.seconds)) {  // CLI11's range check accepts it
    throw UsageError("--seconds: is not a number");
  }
  const std::vector<std::string> ports = options.port.empty() ? serial_ports() : std::vector<std::string>{options.port};
  if (ports.empty()) {
    throw UsageError("no serial port on this machine: name one with --port");
  }
  std::optional<PortVerdict> best;
  for (const std::string& port : ports) {
    search_port(port, options, best);
    if (best && best->verdict == Verdict::kAutopilot) {
      break;
    }
  }
  return *best;
}

/// @returns null if the port has no counters or was not opened.
nlohmann::json to_json(const core::Expected<hal::LineErrors>& errors) {
  if (!errors) {
    return nullptr;
  }
  return {{"framing", errors->framing},
          {"parity", errors->parity},
          {"overrun", errors->overrun},
          {"breaks", errors->breaks}};
}

/// What to do; for a port that cannot be opened, finding and remedy of `m100 doctor`.
std::string remedy_of(const PortVerdict& finding) {
  if (finding.verdict == Verdict::kCannotOpen) {
    const preflight::CheckResult port = preflight::check_port(finding.port);
    return port.finding + ": " + port.remedy;
  }
  return std::string(remedy(finding.verdict));
}

nlohmann::json to_json(const PortVerdict& finding) {
  return {{"port", finding.port},
          {"baud", finding.baud},
          {"verdict", name(finding.verdict)},
          {"remedy", remedy_of(finding)},
          {"line_errors", to_json(finding.errors)},
          {"firmware", name(finding.firmware)},
          {"health", companion::to_json(finding.health)}};
}

void run(const ProbeOptions& options) {
  FileUse().holds("--port", options.port).writes("--json", options.json).check();
  const PortVerdict best = search(options);
  std::cout << "port " << printable(best.port) << ", " << best.baud << " baud: " << name(best.verdict);
  if (best.verdict == Verdict::kAutopilot || best.verdict == Verdict::kNoisy) {
    std::cout << ", " << name(best.firmware) << "\n";
    print(std::cout, best.health);
  } else {
    std::cout << "\n";
  }
  if (!options.json.empty()) {
    write_json(options.json, to_json(best));
  }
  if (best.verdict == Verdict::kCannotOpen && !options.port.empty()) {
    throw UsageError(best.port + ": " + remedy_of(best));
  }
  if (const std::string remedy = remedy_of(best); !remedy.empty()) {
    std::cout << "remedy: " << printable(remedy + holders_note(best.port)) << "\n";
  }
  if (best.verdict != Verdict::kAutopilot) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

void add_probe(CLI::App& m100) {
  CLI::App* app = m100.add_subcommand("probe", "listen only: find port and baud rate, or name what is wrong");
  auto options = std::make_shared<ProbeOptions>();
  app->add_option("--port", options->port, "serial port; default: every port that looks like one");
  app->add_option("--baud", options->baud, "baud rate; 0: every rate that DJI supports")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  app->add_option("--seconds", options->seconds, "seconds to listen at each baud rate")->check(CLI::Range(0.1, 60.0));
  app->add_option("--json", options->json, "result as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::companion
