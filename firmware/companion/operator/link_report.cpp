// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/link_report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <string_view>

#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

double milliseconds(core::Duration duration) { return core::seconds<double>(duration) * 1000.0; }

std::string_view health_line(const link::LinkHealth& health, std::array<char, 1024>& space) {
  std::size_t used = 0;
  const auto add = [&](const char* format, const auto... values) {
    const int wanted = std::snprintf(space.data() + used, space.size() - used, format, values...);
    used = std::min(space.size() - 1, used + static_cast<std::size_t>(std::max(wanted, 0)));
  };
  add("link_health {\"telemetry_rate_hz\":%.4g,\"telemetry_age_s\":%.4g,\"longest_gap_s\":%.4g",
      health.telemetry_rate_hz, core::seconds<double>(health.telemetry_age), core::seconds<double>(health.longest_gap));
  add(",\"receive_share\":%.4g,\"send_share\":%.4g", health.receive_share, health.send_share);
  for (std::size_t bin = 0; bin < health.jitter_histogram.size(); ++bin) {
    add("%s%u", bin == 0 ? ",\"jitter_histogram\":[" : ",", health.jitter_histogram[bin]);
  }
  const protocol::ParserStats& parser = health.parser;
  const auto count = [&](const char* name, std::uint64_t value) {
    add(",\"%s\":%llu", name, static_cast<unsigned long long>(value));
  };
  add("%s", "]");
  count("frames", parser.frames);
  count("crc16_errors", parser.crc16_errors);
  count("crc32_errors", parser.crc32_errors);
  count("resyncs", parser.resyncs);
  count("bytes_dropped", parser.bytes_dropped);
  count("session_repeats", health.sessions.repeats);
  count("session_failures", health.sessions.failures);
  count("bad_packages", health.bad_packages);
  count("old_packages", health.old_packages);
  count("commands_sent", health.commands_sent);
  count("commands_dropped", health.commands_dropped);
  count("outages", health.outages);
  count("restarts", health.restarts);
  add("%s", "}");
  return {space.data(), used};
}

}  // namespace

Json to_json(const link::LinkHealth& health) {
  return {{"telemetry_rate_hz", health.telemetry_rate_hz},
          {"packages", health.packages},
          {"telemetry_age_s", core::seconds<double>(health.telemetry_age)},
          {"longest_gap_s", core::seconds<double>(health.longest_gap)},
          {"receive_share", health.receive_share},
          {"send_share", health.send_share},
          {"jitter_histogram", {{"upper_us", link::LinkHealth::kJitterBins_us}, {"count", health.jitter_histogram}}},
          {"frames", health.parser.frames},
          {"crc16_errors", health.parser.crc16_errors},
          {"crc32_errors", health.parser.crc32_errors},
          {"resyncs", health.parser.resyncs},
          {"bytes_dropped", health.parser.bytes_dropped},
          {"bytes_received", health.bytes_received},
          {"bytes_sent", health.bytes_sent},
          {"session_requests", health.sessions.requests},
          {"session_repeats", health.sessions.repeats},
          {"session_failures", health.sessions.failures},
          {"bad_packages", health.bad_packages},
          {"old_packages", health.old_packages},
          {"refused_items", health.refused_items},
          {"undecipherable", health.undecipherable},
          {"commands_sent", health.commands_sent},
          {"commands_refused", health.commands_refused},
          {"commands_dropped", health.commands_dropped},
          {"outages", health.outages},
          {"restarts", health.restarts}};
}

void log_health(log::FlightLogWriter* log, const app::TickRecord<double>& record, core::TimePoint& logged_at) {
  if (log == nullptr || record.now - logged_at < std::chrono::seconds(1)) {
    return;
  }
  logged_at = record.now;
  std::array<char, 1024> text{};
  log->append(record.now, health_line(record.health, text));
  const est::VibrationStatus& vibration = record.seen.consistency.vibration;
  log->append(log::VibrationRecord{.timestamp = static_cast<std::uint64_t>(record.now.time_since_epoch().count()),
                                   .rms = static_cast<float>(vibration.rms_m_s2),
                                   .peak = static_cast<float>(vibration.peak_m_s2),
                                   .clipped = static_cast<float>(vibration.clipped),
                                   .velocity_sigma = static_cast<float>(vibration.velocity_sigma_m_s)});
}

void print(std::ostream& out, const link::LinkHealth& health) {
  out << std::fixed << std::setprecision(1) << "  telemetry  " << health.telemetry_rate_hz << " packages/s, "
      << health.packages << " in all";
  if (health.packages > 0) {
    out << ", last " << milliseconds(health.telemetry_age) << " ms ago, longest gap "
        << milliseconds(health.longest_gap) << " ms";
  }
  out << "\n"
      << "  line       receiving " << 100.0 * health.receive_share << " %, sending " << 100.0 * health.send_share
      << " % of its capacity\n"
      << "  errors     " << health.parser.crc16_errors << " CRC16, " << health.parser.crc32_errors << " CRC32, "
      << health.parser.resyncs << " resyncs, " << health.parser.bytes_dropped << " bytes dropped, "
      << health.sessions.failures << " session failures\n"
      << "  jitter     ";
  for (std::size_t bin = 0; bin < health.jitter_histogram.size(); ++bin) {
    if (health.jitter_histogram[bin] == 0) {
      continue;
    }
    const bool last = bin == link::LinkHealth::kJitterBins_us.size();
    const std::int64_t edge_us = link::LinkHealth::kJitterBins_us[last ? bin - 1 : bin];
    out << (last ? ">=" : "<") << static_cast<double>(edge_us) / 1000.0 << " ms: " << health.jitter_histogram[bin]
        << "  ";
  }
  out << "\n" << std::defaultfloat;
}

void write_json(const std::string& path, const Json& result) {
  // The autopilot's version text may hold any bytes.
  write_file(path, result.sorted().dump(2) + "\n");
}

void write_result(const std::string& path, const Json& result) {
  try {
    if (!path.empty()) {
      write_json(path, result);
    }
  } catch (const UsageError& wrong) {
    std::cerr << "m100: " << printable(wrong.what()) << "\n";
  }
}

}  // namespace m100::companion
