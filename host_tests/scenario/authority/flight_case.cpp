// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/flight_case.h"

#include <signal.h>

#include <algorithm>
#include <cmath>

namespace m100::authority {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr core::Duration kWarmUp = milliseconds(500);  // of the autopilot, before the client starts
constexpr double kStart_s = 0.5;                       // after the client took part: kStarting
constexpr double kFlown_s = 3.0;                       // after the grant: kFlying
constexpr double kReachStage_s = 25.0;
constexpr double kWatched_s = 5.0;  // after the strike and after the healing
constexpr double kEnding_s = 8.0;   // for the program to end after the operator's stop
constexpr double kAfterwards_s = 1.0;

core::Duration duration_of(double time_s) { return core::Duration{std::llround(time_s * 1e6)}; }

/// Leads the programs to the stage, applies the fault, watches them and stops them.
class FaultDirector {
 public:
  FaultDirector(const Case& wanted, Bench& bench) : case_(wanted), bench_(bench) {}

  FlightTimes direct() {
    run_for(kWarmUp);
    bench_.start_client();
    came_s_ = bench_.autopilot_s();
    if (reach_stage()) {
      strike();
      const double until_s = times_.struck_s + watched_s();
      run_until([&] { return bench_.autopilot_s() >= until_s; });
      stop();
    }
    times_.over_s = bench_.autopilot_s();
    times_.obtained_s = bench_.events().first_s("did", "obtained");
    times_.said = bench_.said();
    if (bench_.other()) {
      times_.found_another = bench_.other()->activated();
      times_.requests_to_the_other = bench_.other()->requests_for_control();
    }
    times_.summed_up = bench_.finish();
    return times_;
  }

 private:
  template <typename Condition>
  bool run_until(const Condition& condition, double at_most_s = 3600.0) {
    const core::TimePoint end = bench_.now() + duration_of(at_most_s);
    while (!condition()) {
      if (bench_.now() >= end) {
        return false;
      }
      bench_.step();
    }
    return true;
  }
  void run_for(core::Duration time) {
    run_until([] { return false; }, core::seconds<double>(time));
  }
  bool happened(std::string_view what, std::string_view name) const {
    return bench_.events().first_s(what, name) != kNever_s;
  }

  bool reach_stage() {
    if (case_.stage == Stage::kStarting) {
      run_for(duration_of(kStart_s));
      return true;
    }
    const auto ended = [this] { return !bench_.client().runs(); };
    const auto asked = [this] { return happened("received", "obtain_control"); };
    if (case_.stage == Stage::kAsking) {
      return run_until([&] { return asked() || ended(); }, kReachStage_s) && asked();
    }
    const auto obtained = [this] { return happened("did", "obtained"); };
    if (!run_until([&] { return obtained() || ended(); }, kReachStage_s) || !obtained()) {
      return false;
    }
    run_for(duration_of(kFlown_s));
    switch (case_.stage) {
      case Stage::kCoasting:
        take_pose_away(0.35);
        break;
      case Stage::kLevel:
        take_pose_away(1.30);
        break;
      case Stage::kRelease:
        take_pose_away(0.0);
        return run_until([&] { return happened("received", "release_control"); }, kReachStage_s);
      case Stage::kReleasing:
        interrupt();
        run_for(milliseconds(10));
        break;
      default:
        break;
    }
    return true;
  }
  void take_pose_away(double for_s) {
    bench_.poses.plan.cut = true;
    times_.pose_taken_away_s = bench_.autopilot_s();
    run_for(duration_of(for_s));
  }
  void interrupt() {
    bench_.client().send(SIGINT);
    times_.stopped_s = bench_.autopilot_s();
  }

  void strike_with(const Fault& fault) {
    fault.strike(bench_);
    if (fault.heal != nullptr) {
      bench_.plan(duration_of(fault.heals_after_s), [this, &fault] { fault.heal(bench_); });
    }
  }
  void strike() {
    times_.struck_s = bench_.autopilot_s();
    strike_with(*case_.fault);
    if (case_.second != nullptr) {
      sim::Random random(case_.seed, "pair");
      const double after_s = random.uniform();
      times_.struck_again_s = times_.struck_s + after_s;
      bench_.plan(duration_of(after_s), [this] { strike_with(*case_.second); });
    }
  }
  double watched_s() const {
    const double second_s = case_.second != nullptr ? 1.0 + case_.second->heals_after_s : 0.0;
    return kWatched_s + std::max(case_.fault->heals_after_s, second_s);
  }

  void stop() {
    times_.ran_until_stopped = bench_.client().runs();
    if (times_.ran_until_stopped && times_.stopped_s == kNever_s) {
      interrupt();
    }
    run_until([&] { return !bench_.client().runs(); }, kEnding_s);
    bench_.let_client_end();
    times_.ending = bench_.client().ending();
    run_for(duration_of(kAfterwards_s));
  }

  const Case& case_;
  Bench& bench_;
  FlightTimes times_;
  double came_s_ = 0.0;
};

}  // namespace

std::string Case::name() const {
  std::string text(fault->name);
  text += second != nullptr ? " + " + std::string(second->name) : "";
  text += ", " + std::string(kStageNames[static_cast<std::size_t>(stage)]);
  text += movement ? ", movement" : ", virtual_rc";
  text += encrypted ? ", encrypted" : "";
  return text + (real_time ? ", real time" : "");
}

Verdict fly(const Case& wanted, const Places& places) {
  Setup setup{
      .movement = wanted.movement, .encrypted = wanted.encrypted, .real_time = wanted.real_time, .seed = wanted.seed};
  for (const Fault* const fault : {wanted.fault, wanted.second}) {
    if (fault != nullptr && fault->prepare != nullptr) {
      fault->prepare(setup);
    }
  }
  if (wanted.counted) {  // live display must not cost allocations in the flying thread
    setup.more_words.insert(setup.more_words.end(), {"--live", "127.0.0.1:9870", "--status", "always"});
  }
  Bench bench(places, setup);
  bench.start_autopilot();
  const FlightTimes times = FaultDirector(wanted, bench).direct();
  return judge(wanted, times, bench.events());
}

}  // namespace m100::authority
