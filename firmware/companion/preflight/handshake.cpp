// SPDX-License-Identifier: BSD-3-Clause
// m100 handshake: start-up, control, neutral commands, release; on the bench, with the propellers off.
#include <iostream>
#include <sstream>
#include <vector>

#include "firmware/companion/backup/backup_process.h"
#include "firmware/companion/backup/release.h"
#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/fly/monitor/release_monitor.h"
#include "firmware/companion/operator/line_writer.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/operator/operator_messages.h"
#include "firmware/companion/operator/terminal.h"
#include "firmware/companion/preflight/first_contact.h"

namespace m100::companion {
namespace {

struct Change {
  core::TimePoint at;
  safety::AuthorityStage stage;
  safety::AuthorityReason reason;
};

link::ChannelCommand neutral_of(const FlyOptions& options) {
  return options.channel == "movement" ? link::ChannelCommand(ctl::Command<double>{})
                                       : link::ChannelCommand(vrc::Sticks{});
}

/// One session with the autopilot. A signal gives control back. However control ends, the session continues until
/// ReleaseMonitor says that the release is over.
class Session final : public OperatorLog {
 public:
  Session(const FlyOptions& options, link::SerialLink& link)
      : options_(options), neutral_(neutral_of(options)), link_(link), first_contact_(*this), release_monitor_(*this) {}

  /// One tick. @returns false: the session is over.
  bool tick(core::TimePoint now) {
    link_.receive(now);
    note_changes(now);
    first_contact_.update(now, link_);
    const link::AuthorityView& authority = link_.authority();
    release_monitor_.update(now, authority);
    if (authority.in_control && phase_ != Phase::kReleasing) {
      obtained_at_ = obtained_ ? obtained_at_ : now;
      obtained_ = true;
      held_until_ = now;
      ++ticks_in_control_;
      (void)link_.send(neutral_, now);
    }
    switch (phase_) {
      case Phase::kStarting:
        return start(now);
      case Phase::kRequested:
        return request_control(now);
      case Phase::kHolding:
        return hold(now);
      case Phase::kReleasing:
        return give_back(now);
    }
    return false;
  }

  void write(core::TimePoint now, std::string_view line) override {
    std::ostringstream timed;
    timed << seconds(now) << " s  " << line;
    print_line(timed.str());
  }

  /// Control was taken, held for its time or until a signal, and the transmitter has it.
  bool succeeded() const { return released_; }
  Json to_json() const {
    Json stages = Json::array();
    for (const Change& change : changes_) {
      stages.push_back({{"t_s", seconds(change.at)},
                        {"stage", safety::name(change.stage)},
                        {"reason", safety::name(change.reason)}});
    }
    return {{"obtained", obtained_},
            {"released", released_},
            {"control_s", core::seconds<double>(held_until_ - obtained_at_)},
            {"ticks_in_control", ticks_in_control_},
            {"stages", stages}};
  }

 private:
  enum class Phase { kStarting, kRequested, kHolding, kReleasing };

  static double seconds(core::TimePoint at) { return core::seconds<double>(at.time_since_epoch()); }

  bool start(core::TimePoint now) {
    if (stop_requested() && link_.authority().release_pending) {
      release(now);  // a previous program may have left control taken
      return true;
    }
    if (link_.authority().stage == safety::AuthorityStage::kReady) {
      release_monitor_.control_requested(link_.health().outages);
      link_.request_control(now);
      phase_ = Phase::kRequested;
      asked_at_ = now;
      return true;
    }
    return seconds(now) <= options_.patience_s && !stop_requested();
  }
  bool request_control(core::TimePoint now) {
    if (link_.authority().in_control) {
      phase_ = Phase::kHolding;
    } else if (was_refused(now)) {
      begin_release(now);
    } else if (stop_requested()) {
      release(now);  // a request may already be granted
    }
    return true;
  }
  bool hold(core::TimePoint now) {
    if (!link_.authority().in_control) {
      begin_release(now);  // lost: no command is sent any more, and control is not requested again
    } else if (stop_requested() || core::seconds<double>(now - obtained_at_) >= options_.hold_s) {
      was_held_ = true;
      release(now);
    }
    return true;
  }
  void release(core::TimePoint now) {
    link_.release(now);
    begin_release(now);
  }
  void begin_release(core::TimePoint now) {
    phase_ = Phase::kReleasing;
    release_monitor_.begin(now, stops());
  }
  bool give_back(core::TimePoint now) {
    if (now > release_monitor_.since() && link_.authority().in_control) {
      link_.release(now);  // a delayed answer has granted control meanwhile
    }
    const ReleaseMonitor::State state = release_monitor_.confirm_release(now, link_, stops());
    released_ = state == ReleaseMonitor::State::kReleased && was_held_ && release_monitor_.pilot_in_control();
    return state == ReleaseMonitor::State::kPending;
  }
  /// The authority table is at a stage that waits for the operator, more than 4 s after our request.
  bool was_refused(core::TimePoint now) const {
    const safety::AuthorityStage stage = link_.authority().stage;
    const bool waits = stage == safety::AuthorityStage::kReady || stage == safety::AuthorityStage::kSilent ||
                       stage == safety::AuthorityStage::kSilentCold;
    return waits && now - asked_at_ > 2 * safety::kRequestSpacing;
  }
  void note_changes(core::TimePoint now) {
    const link::AuthorityView& authority = link_.authority();
    if (!changes_.empty() && changes_.back().stage == authority.stage && changes_.back().reason == authority.reason) {
      return;
    }
    changes_.push_back({now, authority.stage, authority.reason});
    write(now, describe(authority).text());
  }

  const FlyOptions& options_;
  const link::ChannelCommand neutral_;
  link::SerialLink& link_;
  Phase phase_ = Phase::kStarting;
  bool obtained_ = false;
  bool was_held_ = false;
  bool released_ = false;
  core::TimePoint obtained_at_{};
  core::TimePoint held_until_{};
  core::TimePoint asked_at_{};
  FirstContact first_contact_;
  ReleaseMonitor release_monitor_;
  std::uint32_t ticks_in_control_ = 0;
  std::vector<Change> changes_;
};

Json result_of(const FlyOptions& options, const Session& session, const link::SerialLink& link,
               const TickClock& clock) {
  Json out = session.to_json();
  out.update({{"channel", options.channel},
              {"baud", options.baud},
              {"last_stage", safety::name(link.authority().stage)},
              {"last_reason", safety::name(link.authority().reason)},
              {"firmware", protocol::text(link.version().version_name)},
              {"stalls", clock.stalls()},
              {"longest_tick_s", core::seconds<double>(clock.longest())},
              {"health", companion::to_json(link.health())}});
  return out;
}

void shake_hands(const FlyOptions& options) {
  PreparedLink prepared(options);
  if (options.release_only) {
    if (!release_only(options, prepared.config)) {
      throw AnswerIsNo();
    }
    return;
  }
  watch_signals();
  std::cout << "handshake: takes control and sends neutral commands for " << options.hold_s
            << " s; the propellers must be off" << std::endl;
  hal::SerialPort port(options.port, options.baud);
  open_or_explain(port);
  make_terminals_nonblocking();
  BackupProcess backup(neutral_of(options), prepared.config.cipher, options.port);
  LineWriter writer;
  link::SerialLink link(port, prepared.config);
  Session session(options, link);
  TickClock clock(options.port);
  for (core::TimePoint now = clock.now();; now = clock.next()) {
    backup.set_port(port.descriptor(), port.openings());
    if (!backup.heartbeat(link.authority().in_control)) {
      link.release(now);
    }
    if (!session.tick(now)) {
      break;
    }
  }
  link.authority().release_pending ? backup.send_release() : backup.dismiss();
  writer.finish();
  std::ostringstream words;
  words << (session.succeeded() ? "released" : "not completed") << "\n";
  print(words, link.health());
  if (link.health().packages == 0) {
    words << "no telemetry came: m100 probe --port " << printable(options.port) << " tells why\n";
  }
  write_with_timeout(words.str());
  write_result(options.json, result_of(options, session, link, clock));
  if (!session.succeeded()) {
    throw AnswerIsNo();
  }
}

}  // namespace

void add_handshake(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<FlyOptions>(
      "handshake", "on the bench, propellers off: take control, hold it with neutral commands, give it back",
      shake_hands);
  add_link_options(app, *options);
  app.add_option("--hold", options->hold_s, "seconds in control").in_range(0.0, 3600.0);
  app.add_option("--patience", options->patience_s, "seconds to wait for start-up").in_range(1.0, 3600.0);
  app.add_flag("--release-only", options->release_only,
               "only send the release of control, for a flight whose two processes are dead; the service does so");
}

}  // namespace m100::companion
