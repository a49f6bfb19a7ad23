// SPDX-License-Identifier: BSD-3-Clause
// m100 record: listens only, and writes the autopilot's telemetry and the pose into a log for m100-lab identify.
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <optional>
#include <string>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/log_file.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/probe/receive_only_port.h"
#include "firmware/companion/record/recorder.h"
#include "firmware/link/pose/pose_link.h"
#include "hal/linux/serial_port.h"
#include "protocol/aes256.h"

namespace m100::companion {
namespace {

/// Short compared with the 10 ms between packages, because the time of a read is taken as the time of its data.
constexpr core::Duration kVisit = std::chrono::milliseconds(2);
constexpr double kGoodRate_hz = 50.0;  ///< of sticks and attitude, for a fit of the attitude loop

/// Both ports, the log and the recorder.
class Session {
 public:
  explicit Session(const FlyOptions& options) : options_(options), port_(options.port, options.baud) {
    open_or_explain(port_);
    if (!options.pose.port.empty()) {
      pose_port_.emplace(options.pose, options.port);
      pose_listener_.emplace(pose_port_->line());
      pose_link_.emplace(*pose_listener_, pose_port_->baud(), &exchanged_, choice_of(options.pose));
    }
    if (!options.key_file.empty()) {
      cipher_.emplace(read_key(options.key_file));
    }
    log_.emplace(options.log, "the recording ends here");  // last, so that an earlier failure leaves no file
    writer_.emplace(log_->ring());
    recorder_.emplace(*writer_, options.baud, cipher_ ? &*cipher_ : nullptr);
  }

  void run() {
    hal::PortClock clock(options_.port);
    const std::array notes{log::Note{"m100_recording", "listened only; columns: m100_recording.toml"}};
    (void)recorder_->begin(clock.now(), notes);
    log_->start();
    const bool for_ever = options_.hold_s <= 0.0;
    for (core::TimePoint now = clock.now();
         !stop_requested() && !log_->is_cut() &&
         (for_ever || core::seconds<double>(now.time_since_epoch()) < options_.hold_s);
         now = clock.now()) {
      visit(now);
      clock.sleep_until(now + kVisit);
      length_s_ = core::seconds<double>(now.time_since_epoch());
    }
    recorder_->end(clock.now());
    log_->finish();
  }

  const Recorder& recorder() const { return *recorder_; }
  bool is_cut() const { return log_->is_cut(); }
  std::uint32_t dropped() const { return writer_->dropped(); }
  std::uint32_t outages() const { return outages_; }
  const PosePort* pose_port() const { return pose_port_ ? &*pose_port_ : nullptr; }
  /// Precondition of this and the next function: there is a pose port.
  const link::PoseLink& pose_link() const { return *pose_link_; }
  std::string no_pose() const { return why_no_pose(*pose_link_, *pose_port_, exchanged_); }
  double length_s() const { return length_s_; }

 private:
  void visit(core::TimePoint now) {
    for (bool more = true; more;) {
      const core::Expected<std::size_t> count = operator_log_.read(buffer_);
      outages_ += !count && !port_was_gone_ ? 1U : 0U;
      port_was_gone_ = !count;
      more = count && *count > 0;
      if (more) {
        recorder_->take(std::span(buffer_).first(*count), now);
      }
    }
    recorder_->reject_false_frames(now);
    if (pose_link_) {
      pose_port_->tick();
      if (const core::Expected<core::Pose<double>> pose = pose_link_->receive(now)) {
        recorder_->take(*pose);
      }
    }
  }

  const FlyOptions& options_;
  hal::SerialPort port_;
  ReceiveOnlyPort operator_log_{port_};
  std::optional<PosePort> pose_port_;
  std::optional<ReceiveOnlyPort> pose_listener_;
  ExchangedPorts exchanged_;
  std::optional<link::PoseLink> pose_link_;
  std::optional<protocol::Aes256> cipher_;
  std::optional<LogFile> log_;
  std::optional<log::UlogWriter> writer_;
  std::optional<Recorder> recorder_;
  std::array<std::byte, 4096> buffer_{};
  bool port_was_gone_ = false;
  std::uint32_t outages_ = 0;
  double length_s_ = 0.0;
};

constexpr std::array kStreams{Recorder::kRc,    Recorder::kAttitude, Recorder::kRates,  Recorder::kVelocity,
                              Recorder::kForce, Recorder::kPosition, Recorder::kStatus, Recorder::kPose};
constexpr std::array<const char*, 4> kSticks{"roll", "pitch", "throttle", "yaw"};

Json to_json(const FlyOptions& options, const Session& session, const std::string& trouble) {
  const Recorder& recorder = session.recorder();
  Json streams, sticks;
  for (const Recorder::Stream stream : kStreams) {
    const Recorder::StreamStatistics& statistics = recorder.statistics(stream);
    streams[std::string(Recorder::name(stream))] = {{"samples", statistics.samples},
                                                    {"rate_hz", statistics.rate_hz()},
                                                    {"longest_gap_s", core::seconds<double>(statistics.longest_gap)},
                                                    {"gaps", statistics.gaps}};
  }
  for (std::size_t stick = 0; stick < kSticks.size() && recorder.statistics(Recorder::kRc).samples > 0; ++stick) {
    sticks[kSticks[stick]] = {{"least_counts", recorder.sticks()[stick].min_counts},
                              {"most_counts", recorder.sticks()[stick].max_counts}};
  }
  const protocol::ParserStats& parser = recorder.parser();
  const PosePort* const pose = session.pose_port();
  const link::SignedLineStats* const signatures = pose != nullptr ? pose->signatures() : nullptr;
  return {{"recorded", trouble.empty()},
          {"trouble", trouble},
          {"log", options.log},
          {"seconds", session.length_s()},
          {"packages", recorder.packages()},
          {"streams", streams},
          {"sticks", sticks},
          {"packages_of_a_computer", recorder.computer_packages()},
          {"autopilot_restarts", recorder.restarts()},
          {"outages", session.outages()},
          {"poses_lost", pose != nullptr ? session.pose_link().stats().lost_frames : 0},
          {"pose", pose != nullptr ? pose_json(session.pose_link()) : Json{}},
          {"signatures", signatures != nullptr ? companion::to_json(*signatures) : Json{}},
          {"bad_packages", recorder.bad_packages()},
          {"undecipherable", recorder.undecipherable()},
          {"frames", parser.frames},
          {"crc16_errors", parser.crc16_errors},
          {"crc32_errors", parser.crc32_errors},
          {"bytes_dropped", parser.bytes_dropped},
          {"messages_dropped", session.dropped()},
          {"log_cut", session.is_cut()}};
}

/// Why the log is useless for identification; empty: it is usable.
std::string problem_of(const FlyOptions& options, const Session& session) {
  const Recorder& recorder = session.recorder();
  const auto none = [&](Recorder::Stream stream) { return recorder.statistics(stream).samples < 2; };
  if (session.is_cut()) {
    return options.log + ": the log is cut short";
  }
  if (recorder.packages() == 0) {
    return options.port + ": " +
           (recorder.undecipherable() > 0 ? "the telemetry is encrypted; name the app's key with --key-file"
            : recorder.bad_packages() > 0 ? "the telemetry is of another autopilot; m100 probe tells which"
                                          : "no telemetry came; m100 probe tells why");
  }
  if (none(Recorder::kRc) || none(Recorder::kAttitude)) {
    return options.port + ": the telemetry holds no " + (none(Recorder::kRc) ? "sticks" : "attitude") +
           "; switch the item on in DJI's assistant";
  }
  if (!options.pose.port.empty() && none(Recorder::kPose)) {
    return options.pose.port + ": no pose came; " + session.no_pose();
  }
  if (session.pose_port() != nullptr && options.pose.from.empty() && session.pose_link().senders().all().size() > 1) {
    return options.pose.port + ": poses came from " + describe(session.pose_link().senders()) +
           "; the log holds those of one of them: choose with --pose-from SYS:COMP";
  }
  return "";
}

void print(const Session& session) {
  const Recorder& recorder = session.recorder();
  std::cout << std::fixed << std::setprecision(1) << "recorded " << session.length_s() << " s\n";
  for (const Recorder::Stream stream : kStreams) {
    const Recorder::StreamStatistics& statistics = recorder.statistics(stream);
    if (statistics.samples > 0) {
      std::cout << "  " << std::left << std::setw(9) << Recorder::name(stream) << std::right << std::setw(6)
                << statistics.rate_hz() << " Hz, longest gap " << 1000.0 * core::seconds<double>(statistics.longest_gap)
                << " ms, " << statistics.gaps << " gaps\n";
    }
  }
  for (std::size_t stick = 0; stick < kSticks.size() && recorder.statistics(Recorder::kRc).samples > 0; ++stick) {
    const Recorder::StickRange& moved = recorder.sticks()[stick];
    std::cout << "  stick " << kSticks[stick] << " from " << moved.min_counts << " to " << moved.max_counts
              << " counts\n";
  }
  const auto slow = [&](Recorder::Stream stream) { return recorder.statistics(stream).rate_hz() < 0.9 * kGoodRate_hz; };
  if (recorder.packages() > 0 && (slow(Recorder::kRc) || slow(Recorder::kAttitude))) {
    std::cout << "  sticks or attitude come slower than 50 Hz: set them to 50 or 100 Hz in DJI's assistant\n";
  }
  if (recorder.computer_packages() > 0) {
    std::cout << "  a computer had control in " << recorder.computer_packages()
              << " packages: in those, the sticks in the log may not be the pilot's\n";
  }
  if (session.pose_port() != nullptr) {
    companion::print(std::cout, session.pose_link().stats(), session.pose_port()->signatures());
  }
  if (session.dropped() > 0) {
    std::cout << "  " << session.dropped() << " records were lost: the disk was too slow\n";
  }
  std::cout << std::defaultfloat << std::flush;
}

void run_record(const FlyOptions& options) {
  check(options.pose, options.port);
  check_files(options);
  watch_signals();
  Session session(options);
  session.run();
  const std::string trouble = problem_of(options, session);
  print(session);
  write_result(options.json, to_json(options, session, trouble));
  if (!trouble.empty()) {
    if (!session.is_cut()) {  // otherwise the reason was already printed
      std::cerr << "m100: " << printable(trouble) << "\n";
    }
    throw AnswerIsNo();
  }
}

}  // namespace

void add_record(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<FlyOptions>(
      "record", "listen only: write telemetry, the pilot's sticks and the pose into a log for m100-lab identify",
      run_record);
  app.add_option("--port", options->port, "serial port of the autopilot").required();
  app.add_option("--baud", options->baud, "baud rate, as set in DJI's assistant")
      .one_of({115200, 230400, 460800, 921600});
  app.add_option("--key-file", options->key_file, "file with the app's key, if the autopilot encrypts its telemetry");
  add_pose_options(app, options->pose);
  app.add_option(
         "--log", options->log,
         "log to write (ULog); must not exist. Its column maps, on the PC: /usr/share/m100-lab/maps/m100_recording*")
      .required();
  options->hold_s = 0.0;
  app.add_option("--hold", options->hold_s, "seconds to record; 0: until Ctrl-C").in_range(0.0, 86400.0);
  app.add_option("--json", options->json, "rates, gaps and stick travel as JSON");
  app.footer("Exit codes: 0 recorded, 1 nothing that identification could use, or the disk is full, 2 wrong use.");
}

}  // namespace m100::companion
