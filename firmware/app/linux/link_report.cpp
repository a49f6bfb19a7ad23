// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/linux/link_report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "firmware/app/linux/subcommands.h"

namespace m100::app {
namespace {

double milliseconds(core::Duration duration) { return core::seconds<double>(duration) * 1000.0; }

}  // namespace

std::string quoted(std::string_view text) {
  std::ostringstream out;
  out << '"';
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') {
      out << '\\' << letter;
    } else if (static_cast<unsigned char>(letter) < 0x20) {
      out << "\\u" << std::hex << std::setw(4) << std::setfill('0') << static_cast<int>(letter) << std::dec;
    } else {
      out << letter;
    }
  }
  out << '"';
  return out.str();
}

std::string to_json(const LinkHealth& health) {
  std::ostringstream out;
  out << "{\"telemetry_rate_hz\":" << health.telemetry_rate_hz << ",\"packages\":" << health.packages
      << ",\"telemetry_age_s\":" << core::seconds<double>(health.telemetry_age)
      << ",\"longest_gap_s\":" << core::seconds<double>(health.longest_gap)
      << ",\"receive_share\":" << health.receive_share << ",\"send_share\":" << health.send_share
      << ",\"jitter_histogram\":{\"upper_us\":[";
  for (std::size_t bin = 0; bin < LinkHealth::kJitterBins_us.size(); ++bin) {
    out << (bin == 0 ? "" : ",") << LinkHealth::kJitterBins_us[bin];
  }
  out << "],\"count\":[";
  for (std::size_t bin = 0; bin < health.jitter_histogram.size(); ++bin) {
    out << (bin == 0 ? "" : ",") << health.jitter_histogram[bin];
  }
  out << "]},\"frames\":" << health.parser.frames << ",\"crc16_errors\":" << health.parser.crc16_errors
      << ",\"crc32_errors\":" << health.parser.crc32_errors << ",\"resyncs\":" << health.parser.resyncs
      << ",\"bytes_dropped\":" << health.parser.bytes_dropped << ",\"bytes_received\":" << health.bytes_received
      << ",\"bytes_sent\":" << health.bytes_sent << ",\"session_requests\":" << health.sessions.requests
      << ",\"session_repeats\":" << health.sessions.repeats << ",\"session_failures\":" << health.sessions.failures
      << ",\"bad_packages\":" << health.bad_packages << ",\"refused_items\":" << health.refused_items
      << ",\"undecipherable\":" << health.undecipherable << ",\"commands_sent\":" << health.commands_sent
      << ",\"commands_refused\":" << health.commands_refused << ",\"commands_dropped\":" << health.commands_dropped
      << ",\"outages\":" << health.outages << ",\"restarts\":" << health.restarts << "}";
  return out.str();
}

std::string_view health_line(const LinkHealth& health, HealthText& space) {
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
  add("]");
  count("frames", parser.frames);
  count("crc16_errors", parser.crc16_errors);
  count("crc32_errors", parser.crc32_errors);
  count("resyncs", parser.resyncs);
  count("bytes_dropped", parser.bytes_dropped);
  count("session_repeats", health.sessions.repeats);
  count("session_failures", health.sessions.failures);
  count("bad_packages", health.bad_packages);
  count("commands_sent", health.commands_sent);
  count("commands_dropped", health.commands_dropped);
  count("outages", health.outages);
  count("restarts", health.restarts);
  add("}");
  return {space.data(), used};
}

void print(std::ostream& out, const LinkHealth& health) {
  out << std::fixed << std::setprecision(1) << "  telemetry  " << health.telemetry_rate_hz << " packages/s, "
      << health.packages << " in all, last " << milliseconds(health.telemetry_age) << " ms ago, longest gap "
      << milliseconds(health.longest_gap) << " ms\n"
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
    const bool last = bin == LinkHealth::kJitterBins_us.size();
    const std::int64_t edge_us = LinkHealth::kJitterBins_us[last ? bin - 1 : bin];
    out << (last ? ">=" : "<") << static_cast<double>(edge_us) / 1000.0 << " ms: " << health.jitter_histogram[bin]
        << "  ";
  }
  out << "\n" << std::defaultfloat;
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << "\n";
  file.flush();
  if (!file) {
    throw UsageError(path + ": cannot be written");
  }
}

}  // namespace m100::app
