// SPDX-License-Identifier: BSD-3-Clause
// m100 fly --dry-run: the whole way from start-up to release with neutral commands.
#include <iostream>
#include <sstream>
#include <vector>

#include "firmware/app/linux/fly.h"
#include "firmware/app/linux/link_report.h"

namespace m100::app {
namespace {

struct Change {
  core::TimePoint at;
  safety::Stage stage;
  safety::Reason reason;
};

/// The course of one session at the autopilot: start-up, control, neutral commands, release. In a dry run the program
/// is started to do all of it once; else the operator asks and releases by the keys Enter and q.
class Session {
 public:
  Session(const FlyOptions& options, SerialLink& link) : options_(options), link_(link) {}

  /// One tick. @returns false: over.
  bool tick(core::TimePoint now) {
    link_.receive(now);
    note_changes(now);
    const AuthorityView& authority = link_.authority();
    if (authority.in_control) {
      obtained_at_ = obtained_ ? obtained_at_ : now;
      obtained_ = true;
      held_until_ = now;
      ++ticks_in_control_;
      (void)link_.send(neutral(), now);
    }
    if (phase_ == Phase::kStarting && authority.stage == safety::Stage::kReady && wants_control()) {
      link_.request_control(now);
      phase_ = Phase::kAsked;
      asked_at_ = now;
    } else if (phase_ == Phase::kAsked && authority.in_control) {
      phase_ = Phase::kHolding;
    } else if (phase_ == Phase::kAsked && was_refused(now)) {
      return false;
    } else if (phase_ == Phase::kHolding && !authority.in_control) {
      return false;  // lost: nothing is sent any more, and nobody asks again
    } else if ((phase_ == Phase::kHolding && wants_release(now)) || (phase_ == Phase::kAsked && stop_asked())) {
      link_.release(now);  // what is only asked for may already be granted
      phase_ = Phase::kReleasing;
      release_at_ = now;
    } else if (phase_ == Phase::kReleasing && authority.stage != safety::Stage::kReleasing &&
               now > release_at_ + kStep) {
      released_ = authority.reason == safety::Reason::kReleased;
      return false;
    }
    const bool too_long = phase_ == Phase::kStarting && options_.dry_run && seconds(now) > options_.patience_s;
    return !too_long && !(stop_asked() && phase_ == Phase::kStarting);
  }

  bool succeeded() const { return released_; }
  bool obtained() const { return obtained_; }
  const std::vector<Change>& changes() const { return changes_; }
  core::Duration in_control() const { return held_until_ - obtained_at_; }
  std::uint32_t ticks_in_control() const { return ticks_in_control_; }

 private:
  enum class Phase { kStarting, kAsked, kHolding, kReleasing };
  static constexpr core::Duration kStep = core::kTickPeriod;

  static double seconds(core::TimePoint at) { return core::seconds<double>(at.time_since_epoch()); }

  ChannelCommand neutral() const {
    return options_.channel == "movement" ? ChannelCommand(ctl::Command<double>{}) : ChannelCommand(vrc::Sticks{});
  }

  /// Enter was pressed, or the program was started for it.
  bool wants_control() { return options_.dry_run || options_.take_control || key_pressed(); }
  bool wants_release(core::TimePoint now) {
    const bool held = options_.dry_run && now - obtained_at_ >= core::Duration{std::int64_t(options_.hold_s * 1e6)};
    return held || stop_asked() || (!options_.dry_run && key_pressed());
  }
  /// The table has gone back to a stage that waits for the operator.
  bool was_refused(core::TimePoint now) const {
    const safety::Stage stage = link_.authority().stage;
    const bool waits =
        stage == safety::Stage::kReady || stage == safety::Stage::kSilent || stage == safety::Stage::kSilentCold;
    return waits && now - asked_at_ > 2 * safety::kRequestSpacing;
  }
  void note_changes(core::TimePoint now) {
    const AuthorityView& authority = link_.authority();
    if (!changes_.empty() && changes_.back().stage == authority.stage && changes_.back().reason == authority.reason) {
      return;
    }
    changes_.push_back({now, authority.stage, authority.reason});
    std::ostringstream line;
    line << seconds(now) << " s  " << describe(authority);
    say(line.str());
  }

  const FlyOptions& options_;
  SerialLink& link_;
  Phase phase_ = Phase::kStarting;
  bool obtained_ = false;
  core::TimePoint obtained_at_{};
  core::TimePoint held_until_{};
  std::uint32_t ticks_in_control_ = 0;
  core::TimePoint asked_at_{};
  core::TimePoint release_at_{};
  bool released_ = false;
  std::vector<Change> changes_;
};

std::string to_json(const FlyOptions& options, const Session& session, const SerialLink& link, const TickClock& clock) {
  std::ostringstream out;
  out << "{\"channel\":" << quoted(options.channel) << ",\"baud\":" << options.baud
      << ",\"obtained\":" << (session.obtained() ? "true" : "false")
      << ",\"released\":" << (session.succeeded() ? "true" : "false")
      << ",\"last_stage\":" << quoted(safety::name(link.authority().stage))
      << ",\"last_reason\":" << quoted(safety::name(link.authority().reason))
      << ",\"firmware\":" << quoted(protocol::text(link.version().version_name)) << ",\"stalls\":" << clock.stalls()
      << ",\"longest_tick_s\":" << core::seconds<double>(clock.longest())
      << ",\"control_s\":" << core::seconds<double>(session.in_control())
      << ",\"ticks_in_control\":" << session.ticks_in_control() << ",\"stages\":[";
  for (std::size_t i = 0; i < session.changes().size(); ++i) {
    const Change& change = session.changes()[i];
    out << (i == 0 ? "" : ",") << "{\"t_s\":" << core::seconds<double>(change.at.time_since_epoch())
        << ",\"stage\":" << quoted(safety::name(change.stage)) << ",\"reason\":" << quoted(safety::name(change.reason))
        << "}";
  }
  out << "],\"health\":" << to_json(link.health()) << "}";
  return out.str();
}

}  // namespace

bool dry_run(const FlyOptions& options, const LinkConfig& config, hal::SerialPort& port) {
  SerialLink link(port, config);
  Session session(options, link);
  TickClock clock;
  for (core::TimePoint now = clock.now(); session.tick(now); now = clock.next()) {
  }
  std::cout << (session.succeeded() ? "released" : "not completed") << "\n";
  print(std::cout, link.health());
  if (!options.json.empty()) {
    write_file(options.json, to_json(options, session, link, clock));
  }
  return session.succeeded();
}

}  // namespace m100::app
