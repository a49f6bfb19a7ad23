// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/pose_port.h"

#include <time.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/signature_times_file.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/preflight/serial_ports.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

constexpr std::uint32_t kTicksPerOffer = 25;
constexpr std::int64_t kNanosecondsPerSignatureTick = 10000;
constexpr std::uint8_t kLinkOfTheTick = 1;  ///< link number in the signatures of the thread that flies

/// Signature time by the machine's calendar; zero before its origin, as on a board whose clock has no battery.
mavlink::SignatureTime signature_time() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t since_s = static_cast<std::int64_t>(now.tv_sec) - mavlink::kSignatureEpoch_s;
  return since_s < 0 ? 0
                     : static_cast<mavlink::SignatureTime>(since_s) * mavlink::kSignatureTicksPerSecond +
                           static_cast<mavlink::SignatureTime>(now.tv_nsec / kNanosecondsPerSignatureTick);
}

mavlink::Key mavlink_key(const std::string& path) {
  const protocol::CipherKey read = read_key(path);
  mavlink::Key key;
  static_assert(sizeof(read) == sizeof(key));
  std::transform(read.begin(), read.end(), key.begin(), [](std::uint8_t byte) { return std::byte{byte}; });
  return key;
}

}  // namespace

void check(const PoseOptions& options, const std::string& autopilot) {
  if (const std::string conflict = conflict_of(options); !conflict.empty()) {
    throw UsageError(conflict);
  }
  const bool is_network = hal::is_udp(options.port);
  std::error_code error;
  if (!options.port.empty() && !is_network &&
      (options.port == autopilot || std::filesystem::equivalent(options.port, autopilot, error))) {
    throw UsageError("--pose-port: " + options.port + " is the autopilot's port, too: name the port of the poses" +
                     holders_note(options.port));
  }
  if (!options.port.empty() && !is_network && hal::is_simulated(autopilot) != hal::is_simulated(options.port)) {
    throw UsageError("--pose-port: a simulated port and a real one have different clocks, and do not go together");
  }
}

FileUse files_of(const PoseOptions& options, const std::string& autopilot) {
  FileUse use;
  use.holds("--port", autopilot).reads("--mavlink-key", options.key_file);
  if (!hal::is_udp(options.port)) {
    use.holds("--pose-port", options.port);
  }
  if (!options.key_file.empty()) {
    use.writes("--mavlink-key", SignatureTimesFile::path_for(options.key_file));
  }
  return use;
}

PosePort::PosePort(const PoseOptions& options, const std::string& clock_port)
    : options_(options), clock_port_(clock_port), clock_(clock_port), start_(signature_time()) {
  if (hal::is_udp(options.port)) {
    const std::optional<std::uint16_t> loopback = hal::loopback_port_of(options.port);
    udp_.emplace(loopback ? *loopback : *hal::udp_port_of(options.port),
                 loopback ? hal::UdpReach::kLoopback : hal::UdpReach::kNetwork);
    line_ = &reply_to_sender_.emplace(*udp_, choice_of(options));  // with a key the SignedLine does it
    if (const core::Status opened = udp_->open(); opened != core::Status::kOk) {
      throw UsageError(options.port + (opened == core::Status::kRefused
                                           ? ": no permission to open it, or another program holds it"
                                           : ": this machine has no network"));
    }
  } else {
    serial_.emplace(options.port, options.baud);
    line_ = &*serial_;
    open_or_explain(*serial_);
  }
  if (!options.key_file.empty()) {
    key_ = mavlink_key(options.key_file);
    replay_file_ = std::make_unique<SignatureTimesFile>(options.key_file);
    if (udp_) {
      signed_.emplace(*udp_, key_, replay_file_->accepted_before(), kLinkOfTheTick);
    } else {
      signed_.emplace(*serial_, key_, replay_file_->accepted_before(), kLinkOfTheTick);
    }
    signed_->accept_any_clock(options.accept_clock);
    line_ = &*signed_;
    replay_file_->start();
  }
}

PosePort::~PosePort() {
  if (replay_file_) {
    replay_file_->finish(signed_->memory());
  }
}

void PosePort::tick() {
  if (!signed_) {
    return;
  }
  const core::TimePoint now = clock_.now();
  constexpr std::int64_t kMicrosecondsPerSignatureTick = kNanosecondsPerSignatureTick / 1000;
  signed_->tick(now, start_ + static_cast<mavlink::SignatureTime>(now.time_since_epoch().count() /
                                                                  kMicrosecondsPerSignatureTick));
  if (++ticks_ % kTicksPerOffer == 0) {
    replay_file_->offer(signed_->memory());
  }
}

void ExchangedPorts::received(std::span<const std::byte> bytes, core::TimePoint /*now*/) {
  parser_.consume(bytes, [&](const protocol::FrameView& /*frame*/) { ++frames_; });
}

namespace {

/// Why frames with a good checksum do not pass; empty: none was refused.
std::string why_not_signed(const link::SignedLineStats& signatures) {
  if (signatures.old > 0) {
    std::ostringstream text;
    text.precision(0);
    text << std::fixed << "frames come, signed with this key, "
         << static_cast<double>(signatures.old_by) / static_cast<double>(mavlink::kSignatureTicksPerSecond)
         << " s behind this board's clock: set the sender's or the board's clock, or start with --accept-clock";
    return text.str();
  }
  return signatures.refused() > 0 ? "frames come, but none passes their signature" : "";
}

}  // namespace

std::string describe_refusals(const link::PoseLinkStats& poses) {
  std::string text;
  for (std::size_t i = 1; i < poses.faults.size(); ++i) {
    if (poses.faults[i] > 0) {
      text += (text.empty() ? "" : "; ") + std::to_string(poses.faults[i]) + " with " +
              std::string(link::kPoseFaultTexts[i].sentence);
    }
  }
  return text;
}

std::string describe(const link::PoseSenders& senders) {
  std::ostringstream text;
  text.precision(3);
  for (const link::PoseSenders::Sender& sender : senders.all()) {
    text << (text.tellp() > 0 ? " and " : "") << "system " << +sender.from.system << " component "
         << +sender.from.component << " (" << sender.rate_hz() << " poses a second)";
  }
  return text.str();
}

std::string why_no_pose(const link::PoseLink& link, const PosePort& port, const ExchangedPorts& exchanged) {
  const link::SignedLineStats* const signatures = port.signatures();
  const std::string not_signed = signatures != nullptr ? why_not_signed(*signatures) : "";
  const std::string refusals = describe_refusals(link.stats());
  const std::string seen =
      exchanged.seen()    ? "this is the autopilot's line: --port and --pose-port are exchanged"
      : !refusals.empty() ? "poses came and were refused: " + refusals
      : link.parser_stats().bytes == 0
          ? (not_signed.empty() ? "not one byte came" + holders_note(port.name()) : not_signed)
      : link.parser_stats().frames == 0
          ? "bytes came that are not MAVLink 2: check the baud rate, and whether --port and --pose-port are exchanged" +
                holders_note(port.name())
          : "MAVLink came, but without a pose";
  return seen + " (m100 expects ATT_POS_MOCAP, VISION_POSITION_ESTIMATE or ODOMETRY)" +
         (signatures != nullptr ? "; " + describe(*signatures) : "");
}

std::string describe(const link::SignedLineStats& signatures) {
  std::ostringstream text;
  text << signatures.accepted << " frames signed with the key; refused: " << signatures.unsigned_frames << " unsigned, "
       << signatures.wrong << " with a wrong signature, " << signatures.replayed << " sent before or overtaken, "
       << signatures.old << " with an old time stamp, " << signatures.too_many
       << " from more senders than are remembered";
  return text.str();
}

Json to_json(const link::SignedLineStats& signatures) {
  return {{"accepted", signatures.accepted},
          {"unsigned", signatures.unsigned_frames},
          {"wrong", signatures.wrong},
          {"replayed", signatures.replayed},
          {"old", signatures.old},
          {"too_many_senders", signatures.too_many},
          {"full_ticks", signatures.interrupted}};
}

Json pose_json(const link::PoseLink& link) {
  Json refused = Json::object();
  for (std::size_t i = 1; i < link.stats().faults.size(); ++i) {
    if (link.stats().faults[i] > 0) {
      refused[std::string(link::kPoseFaultTexts[i].name)] = link.stats().faults[i];
    }
  }
  Json senders = Json::array();
  for (const link::PoseSenders::Sender& sender : link.senders().all()) {
    senders.push_back({sender.from.system, sender.from.component, sender.poses});
  }
  return {{"used", link.stats().poses}, {"refused", refused}, {"senders", senders}};
}

Json to_json(const link::PoseLinkStats& poses, const link::SignedLineStats* signatures) {
  Json out{{"poses", poses.poses},
           {"refused", poses.refused},
           {"refused_order", poses.refused_order},
           {"refused_senders", poses.refused_senders},
           {"lost_frames", poses.lost_frames},
           {"answers", poses.answers}};
  if (signatures != nullptr) {
    out["signatures"] = to_json(*signatures);
  }
  return out;
}

void print(std::ostream& out, const link::PoseLinkStats& poses, const link::SignedLineStats* signatures) {
  out << "  pose       " << poses.poses << " taken, " << poses.lost_frames << " frames lost, refused: " << poses.refused
      << " impossible, " << poses.refused_order << " out of order, " << poses.refused_senders << " of another sender\n";
  if (const std::string refusals = describe_refusals(poses); !refusals.empty()) {
    out << "             " << refusals << "\n";
  }
  if (signatures != nullptr) {
    out << "  signatures " << describe(*signatures) << "\n";
  }
}

}  // namespace m100::companion
