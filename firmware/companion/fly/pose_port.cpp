// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/pose_port.h"

#include <time.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/signature_times_file.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/fly/fly.h"
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

void add_pose_options(CLI::App& app, PoseOptions& options) {
  app.add_option("--pose-port", options.port,
                 "where the pose comes from (MAVLink: ATT_POS_MOCAP, VISION_POSITION_ESTIMATE or ODOMETRY): a serial "
                 "port, or udp:PORT, which needs --mavlink-key");
  app.add_option("--pose-baud", options.baud, "baud rate of the pose port, if it is a serial port")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  app.add_option("--mavlink-key", options.key_file,
                 "file with the key of the signatures (64 hexadecimal digits, readable by its owner only); frames that "
                 "are not signed with it, or that were sent before, are refused");
}

void check(const PoseOptions& options, const std::string& autopilot) {
  const bool is_network = hal::is_udp(options.port);
  if (is_network && !hal::udp_port_of(options.port)) {
    throw UsageError("--pose-port: " + options.port + ": a UDP port is written udp:PORT, PORT from 1 to 65535");
  }
  if (is_network && options.key_file.empty()) {
    throw UsageError("--pose-port: " + options.port +
                     ": poses over a network must be signed; name the key with --mavlink-key");
  }
  if (options.port.empty() && !options.key_file.empty()) {
    throw UsageError("--mavlink-key: is the key of the pose port, and needs --pose-port");
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
  if (const std::optional<std::uint16_t> port = hal::udp_port_of(options.port)) {
    udp_.emplace(*port);
    line_ = &*udp_;
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
    line_ = &*signed_;
    replay_file_->start();
  }
}

PosePort::~PosePort() {
  if (replay_file_) {
    replay_file_->finish(signed_->memory());
  }
}

TelemetryStream* PosePort::start_telemetry_stream() {
  if (udp_ && signed_) {
    telemetry_stream_ = std::make_unique<TelemetryStream>(*udp_, key_);
    telemetry_stream_->start();
  }
  return telemetry_stream_.get();
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

std::string why_no_pose(const link::PoseLink& link, const PosePort& port) {
  const std::string seen = link.parser_stats().bytes == 0    ? "not one byte came"
                           : link.parser_stats().frames == 0 ? "bytes came that are not MAVLink 2: check the baud rate"
                           : link.stats().refused > 0 ? "poses came and were refused: wrong frame, quaternion or range"
                                                      : "MAVLink came, but without a pose";
  const link::SignedLineStats* const signatures = port.signatures();
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

nlohmann::json to_json(const link::SignedLineStats& signatures) {
  return {{"accepted", signatures.accepted},
          {"unsigned", signatures.unsigned_frames},
          {"wrong", signatures.wrong},
          {"replayed", signatures.replayed},
          {"old", signatures.old},
          {"too_many_senders", signatures.too_many},
          {"full_ticks", signatures.interrupted}};
}

nlohmann::json to_json(const link::PoseLinkStats& poses, const link::SignedLineStats* signatures) {
  nlohmann::json out{{"poses", poses.poses},
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
  if (signatures != nullptr) {
    out << "  signatures " << describe(*signatures) << "\n";
  }
}

}  // namespace m100::companion
