// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/pose_checks.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware/companion/fly/fly.h"
#include "firmware/companion/fly/pose_port.h"
#include "firmware/companion/operator/pose_monitor.h"
#include "firmware/companion/subcommands.h"
#include "firmware/link/pose/pose_link.h"

namespace m100::companion::preflight {
namespace {

constexpr double kListen_s = 2.0;
constexpr double kMaxLostShare = 0.05;
constexpr double kBitsPerByte = 10.0;

/// Judges the poses received in kListen_s.
CheckResult judge(const link::PoseLink& link, const PosePort& port, const ExchangedPorts& exchanged,
                  const PosePlan& line) {
  const link::PoseLinkStats& seen = link.stats();
  CheckResult check{.name = "poses", .health = Health::kGood, .finding = "", .remedy = ""};
  const double rate_hz = static_cast<double>(seen.poses) / kListen_s;
  const double lost = static_cast<double>(seen.lost_frames) /
                      std::max(1.0, static_cast<double>(link.parser_stats().frames + seen.lost_frames));
  std::ostringstream finding;
  finding << std::lround(rate_hz) << " a second, " << std::lround(100.0 * lost) << " % of the frames lost";
  if (!hal::is_udp(line.source.port)) {
    const double share = static_cast<double>(link.parser_stats().bytes) * kBitsPerByte / (kListen_s * line.source.baud);
    finding << ", " << std::lround(100.0 * share) << " % of " << line.source.baud << " baud";
    if (share > mavlink::kMaxPoseShare) {
      check.health = Health::kBad;
      check.remedy = "use a higher baud rate, fewer poses, or ATT_POS_MOCAP without its covariance";
    }
  }
  if (port.signatures() != nullptr) {
    finding << "; " << describe(*port.signatures());
  }
  if (seen.poses == 0) {
    finding.str("none came; " + why_no_pose(link, port, exchanged));
    check.health = Health::kBad;
    check.remedy = "check the source of pose";
  } else if (link.senders().all().size() > 1 && line.source.from.empty()) {
    finding << "; from several senders: " << describe(link.senders());
    check.health = Health::kBad;
    check.remedy = "choose one with --pose-from SYS:COMP";
  } else if (const std::string refusals = describe_refusals(seen); !refusals.empty()) {
    finding << "; refused: " << refusals;
    check.health = Health::kDoubtful;
    check.remedy = "mend what the source sends";
  } else if (check.health == Health::kGood && (rate_hz < PoseMonitor::kMinPoses_hz || lost > kMaxLostShare)) {
    check.health = Health::kDoubtful;
    check.remedy = "send 50 poses a second or more, over a line that loses none";
  }
  check.finding = finding.str();
  return check;
}

}  // namespace

std::vector<std::string> pose_messages() {
  std::vector<std::string> names;
  names.reserve(std::size(mavlink::kPoseWires));
  for (const mavlink::PoseWire& wire : mavlink::kPoseWires) {
    names.emplace_back(wire.name);
  }
  return names;
}

CheckResult check_pose_line(const PosePlan& line) {
  mavlink::PoseWire wire = *std::find_if(mavlink::kPoseWires.begin(), mavlink::kPoseWires.end(),
                                         [&](const auto& one) { return one.name == line.message; });
  wire.bytes += line.source.key_file.empty() ? 0 : mavlink::kSignatureBytes;
  const double share = mavlink::line_share(wire, line.rate_hz, line.source.baud);
  std::ostringstream finding;
  finding << wire.name << " (" << wire.bytes << " bytes) at " << line.rate_hz << " Hz takes "
          << std::lround(100.0 * share) << " % of " << line.source.baud << " baud";
  const bool fits = share <= mavlink::kMaxPoseShare;
  return {"pose line", fits ? Health::kGood : Health::kBad, finding.str(),
          fits ? "" : "use a higher baud rate, fewer poses, or ATT_POS_MOCAP without its covariance"};
}

std::vector<CheckResult> check_pose_port(const PosePlan& line) {
  const PoseOptions& options = line.source;
  if (options.port.empty()) {
    return {};
  }
  const std::string name = "pose port " + options.port;
  try {
    check(options, line.autopilot_port.empty() ? options.port + "?" : line.autopilot_port);
    PosePort port(options, options.port);
    ExchangedPorts exchanged;
    link::PoseLink link(port.line(), port.baud(), &exchanged, choice_of(options));
    TickClock clock(options.port, [&] { port.mark_arrived(); });
    for (core::TimePoint now = clock.now(); core::seconds<double>(now.time_since_epoch()) < kListen_s;
         now = clock.next()) {
      port.tick();
      (void)link.receive(now);
    }
    return {{name, Health::kGood, options.key_file.empty() ? "opens" : "opens, and the key can be read", ""},
            judge(link, port, exchanged, line)};
  } catch (const UsageError& error) {  // of the port or of the key: its message holds the remedy
    return {{name, Health::kBad, error.what(), "do what the finding says"}};
  }
}

}  // namespace m100::companion::preflight
