// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "host_tests/scenario/authority/flight_case.h"

namespace m100::authority {
namespace {

constexpr double kStop_s = 1.0;      // R15
constexpr double kHealed_s = 1.3;    // R15 after the return of the line: 1.0 s, plus reopening every 0.2 s
constexpr double kSpacing_s = 1.98;  // R4: 2 s, with 20 ms tolerance for the line and the steps of both programs
constexpr std::size_t kRequests = 3;

// Tolerance for R4, by which the last control byte may leave one command period after the loss. The autopilot sees it
// later: telemetry reports the loss up to 10 ms later, and both frames take time on the line (6.2 ms and 3.6 ms at
// 230400 baud).
constexpr double kTelling_s = 0.020;

std::string text_of(double value) {
  std::array<char, 32> text{};
  (void)std::snprintf(text.data(), text.size(), "%.3f", value);
  return text.data();
}

class Judge {
 public:
  Judge(const Case& flown, const FlightTimes& times, const Events& events)
      : case_(flown), times_(times), events_(events) {}

  Verdict judge() {
    if (!times_.summed_up) {
      object("the autopilot wrote no summary");
      return verdict_;
    }
    lag_s_ = case_.real_time ? events_.summary().at("longest_lag_s").get<double>() : 0.0;
    if (!flew_before()) {
      verdict_.counted = false;
      object("the program did not reach the stage");
      return verdict_;
    }
    returned();
    requests();
    last_bytes();
    neutral();
    ending();
    words();
    verdict_.drift_m = events_.farthest_from_m(times_.struck_s);
    return verdict_;
  }

 private:
  void object(const std::string& what) { verdict_.violations.push_back(what); }
  std::array<const Fault*, 2> faults() const { return {case_.fault, case_.second}; }
  template <typename Condition>
  bool any(const Condition& condition) const {
    const auto both = faults();
    return std::any_of(both.begin(), both.end(),
                       [&](const Fault* fault) { return fault != nullptr && condition(*fault); });
  }
  double struck_s(const Fault* fault) const {
    return fault == case_.second && fault != case_.fault ? times_.struck_again_s : times_.struck_s;
  }

  bool flew_before() const {
    if (times_.struck_s == kNever_s) {
      return false;
    }
    if (case_.stage == Stage::kStarting || case_.stage == Stage::kAsking) {
      return true;
    }
    return events_.commands_taken_before(times_.struck_s) > 10 && events_.client_flew_at(times_.struck_s - 0.05);
  }

  /// Interval in which our bytes could not reach the autopilot; from_s is infinity if there was none.
  struct Mute {
    double from_s = kNever_s;
    double to_s = kNever_s;
  };
  Mute mute() const {
    Mute result;
    for (const Fault* const fault : faults()) {
      if (fault != nullptr && (fault->reach == FaultReach::kMute || fault->reach == FaultReach::kTaken)) {
        const double healed_s = fault->heal != nullptr ? struck_s(fault) + fault->heals_after_s : kNever_s;
        result.to_s = result.from_s == kNever_s ? healed_s : std::max(result.to_s, healed_s);
        result.from_s = std::min(result.from_s, struck_s(fault));
      }
    }
    return result;
  }

  /// Duration of the stall, if the fault is one: everything due in that time is due later by it (R15 counts from the
  /// end of a stall). After a permanent stop the second process must act, within the time of a death.
  static double stands_still_s(const Fault& fault) {
    constexpr std::string_view kStall = "stall of ";
    if (fault.name.starts_with(kStall)) {
      return std::stod(std::string(fault.name.substr(kStall.size())));
    }
    return fault.name.starts_with("SIGSTOP") ? kDeath_s : 0.0;
  }

  /// Limit for a fault. A stopped program does not reopen a port that came back, and the second process cannot reopen
  /// it, because it does not know the port's name.
  double within_s(const Fault& fault) const {
    constexpr std::string_view kStop = "SIGSTOP for ";
    const bool port_was_gone = any([&](const Fault& other) {
      return &other != &fault && other.group == Group::kPort && struck_s(&other) < struck_s(&fault) + kDeath_s;
    });
    return port_was_gone && fault.name.starts_with(kStop)
               ? std::stod(std::string(fault.name.substr(kStop.size()))) + kHealed_s
               : fault.within_s;
  }

  /// Due time: `within_s` after t_s, later if the line was mute or the program stalled meanwhile.
  double due_after(double t_s, double within_s) {
    double due_s = t_s + within_s;
    const Mute silent = mute();
    if (silent.from_s < due_s && silent.to_s > t_s) {
      due_s = std::max(due_s, silent.to_s + kHealed_s);
    }
    for (const Fault* const fault : faults()) {
      const double still_s = fault != nullptr ? stands_still_s(*fault) : 0.0;
      due_s += still_s > 0.0 && struck_s(fault) != t_s && struck_s(fault) < due_s && struck_s(fault) + still_s > t_s
                   ? still_s
                   : 0.0;
    }
    return due_s;
  }

  /// The transmitter must have control `within_s` after t_s, or after the line came back.
  void expect_return(double t_s, double within_s, const std::string& why) {
    if (t_s == kNever_s || any([](const Fault& fault) { return fault.reach == FaultReach::kLate; })) {
      return;
    }
    const double due_s = due_after(t_s, within_s);
    if (due_s + lag_s_ > times_.over_s) {
      return;  // the case ended before the limit
    }
    const double from_s = events_.transmitter_from_s(t_s);
    if (from_s > due_s + lag_s_) {
      object(why + ": " +
             (from_s == kNever_s ? "control never given back"
                                 : "control given back after " + text_of(from_s - t_s) + " s") +
             ", due within " + text_of(due_s - t_s) + " s");
    } else if (events_.transmitter_for_good_s() > due_s + lag_s_ && !may_fly_again()) {
      object(why + ": control was taken again");
    }
  }
  bool may_fly_again() const { return case_.stage == Stage::kStarting || case_.stage == Stage::kAsking; }

  void returned() {
    const double from_s = events_.transmitter_from_s(times_.struck_s);
    verdict_.returned_after_s = from_s - times_.struck_s;
    const bool in_flight = events_.client_flew_at(times_.struck_s);
    for (const Fault* const fault : faults()) {
      if (fault == nullptr || fault->within_s == 0.0) {
        continue;
      }
      const bool over_before = stands_still_s(*fault) > 0.0 && fault->name != "SIGSTOP" && !in_flight;
      if ((fault->group == Group::kAuthority || over_before) && may_fly_again()) {
        continue;  // control was not taken before: it may be granted afterwards on the operator's order
      }
      // Control that was granted after the strike counts from the grant.
      const double granted_s = in_flight || times_.obtained_s == kNever_s ? 0.0 : times_.obtained_s;
      expect_return(std::max(struck_s(fault), granted_s), within_s(*fault), std::string(fault->name));
    }
    expect_return(times_.pose_taken_away_s, kFailsafe_s, "pose taken away");
    expect_return(times_.stopped_s, kStop_s, "operator's stop");
    if (case_.stage == Stage::kFlying && case_.second == nullptr && case_.fault->flies_on &&
        events_.transmitter_from_s(times_.struck_s) < times_.stopped_s - 0.1) {
      object("the flight ended although it must continue");
    }
  }

  void requests() {
    const Json& summary = events_.summary();
    if (summary.at("obtain_requests").get<std::size_t>() > kRequests) {
      object("requested control " + std::to_string(summary.at("obtain_requests").get<int>()) + " times");
    }
    const bool was_replaced = any([](const Fault& fault) { return fault.name == "another autopilot plugged in"; });
    const bool two_at_the_plug = case_.second != nullptr && case_.fault->group == Group::kPort &&
                                 case_.second->group == Group::kPort;  // one undoes the effect of the other
    if (was_replaced && !two_at_the_plug && !times_.found_another) {
      object("the link did not start up with the autopilot that was plugged in");
    }
    if (times_.requests_to_the_other > 0) {
      object("requested control of another autopilot");
    }
    const double spacing_s = summary.at("least_obtain_spacing_s").get<double>();
    const bool repeats_frames = any([](const Fault& fault) { return fault.group == Group::kLine; });
    if (spacing_s >= 0.0 && spacing_s < kSpacing_s - lag_s_ && !repeats_frames) {
      object("requested control again after " + text_of(spacing_s) + " s");
    }
  }

  static bool is_loss(const Event& event) {
    constexpr std::array kLosses{"left_f",
                                 "taken_by_mobile",
                                 "taken_by_rc",
                                 "rc_off",
                                 "ended_by_script",
                                 "virtual_rc_silent",
                                 "virtual_rc_silent_failsafe"};
    return (event.what == "did" && std::find(kLosses.begin(), kLosses.end(), event.name) != kLosses.end()) ||
           (event.what == "did" && event.name == "restart");
  }
  static bool is_control(const Event& event) {
    return event.name == "vrc_data" || event.name == "movement" ||
           (event.what == "received" && event.name == "obtain_control");
  }
  void last_bytes() {
    double lost_s = kNever_s;
    for (const Event& event : events_.all()) {
      if (is_loss(event)) {
        lost_s = std::min(lost_s, event.t_s);
      } else if (event.what == "did" && event.name == "obtained") {
        lost_s = kNever_s;
      } else if (lost_s != kNever_s && is_control(event) && times_.obtained_s < lost_s) {
        verdict_.last_byte_after_loss_s = std::max(verdict_.last_byte_after_loss_s, event.t_s - lost_s);
      }
    }
    const bool can_know =
        !any([](const Fault& fault) { return fault.group == Group::kLine || fault.group == Group::kPort; });
    const double period_s = case_.movement ? 0.020 : 0.040;
    if (can_know && verdict_.last_byte_after_loss_s > period_s + kTelling_s + lag_s_) {
      object("last control byte " + text_of(verdict_.last_byte_after_loss_s * 1e3) + " ms after the loss");
    }
  }

  /// Checks the failsafe's last states: level for 1 s, in which the aircraft brakes and holds, and then trimmed neutral
  /// for 0.5 s before control goes back.
  void neutral() {
    if (case_.second != nullptr || case_.stage != Stage::kFlying || case_.fault->name != "pose lost") {
      return;
    }
    constexpr double kLevelAndNeutral_s = 1.5;
    constexpr double kNeutral_s = 0.5;
    constexpr double kPoseFresh_s = 0.06;
    // The stick map first sends the remainder of the earlier commands, at most one dead zone (CommandMap): a few sticks
    // at the edge of the zone. Without the neutral half second the sticks would move until the end (observed: 0.06 s).
    constexpr double kRemainder_s = 0.3;
    double given_back_s = kNever_s;
    double since_s = 0.0;
    double last = 0.0;
    for (const Event& event : events_.all()) {
      const bool is_sticks = event.what == "received" && event.name == "vrc_data";
      if (event.t_s > times_.struck_s && event.what == "received" && event.name == "release_control") {
        given_back_s = event.t_s;
        break;
      }
      since_s = is_sticks && event.value != last ? event.t_s : since_s;
      last = is_sticks ? event.value : last;
    }
    if (given_back_s - times_.struck_s < kPoseFresh_s + kLevelAndNeutral_s - lag_s_) {
      object("given back " + text_of(given_back_s - times_.struck_s) +
             " s after the last pose; level and neutral take 1.5 s");
    }
    if (!case_.movement && given_back_s - since_s < kNeutral_s - kRemainder_s - lag_s_) {
      object("the sticks were at neutral for only " + text_of(given_back_s - since_s) + " s before control went back");
    }
  }

  void exit_code() {
    const bool flew = times_.obtained_s != kNever_s;
    if (flew && times_.ending == 2) {
      object("exit code 2 after a flight");
    }
    if (!flew && times_.ending == 0) {
      object("exit code 0 without a flight");
    }
  }

  void ending() {
    const bool by_fault = any([](const Fault& fault) { return fault.ends_program; });
    const bool never_came = case_.stage == Stage::kStarting && times_.obtained_s == kNever_s;
    if (!times_.ran_until_stopped && !by_fault && !never_came && case_.stage != Stage::kReleasing) {
      object("the program ended by itself, code " + std::to_string(times_.ending.value_or(-1)));
    }
    if (any([](const Fault& fault) { return fault.ends_alone; }) && (times_.ran_until_stopped || times_.ending != 1)) {
      object("the program did not end by itself with exit code 1");
    }
    exit_code();
    const bool unreachable = mute().from_s != kNever_s && mute().to_s == kNever_s;
    const bool killed = any([](const Fault& fault) {
      return fault.name == "SIGKILL" || fault.name == "SIGSEGV" || fault.name == "SIGABRT" || fault.name == "SIGSTOP";
    });
    const bool deaf = any([](const Fault& fault) { return fault.reach == FaultReach::kDeaf && fault.heal == nullptr; });
    if (killed || unreachable || deaf) {
      return;  // a killed program has no exit code; one without a line keeps trying to give back
    }
    if (!times_.ending) {
      object("the program did not end after the operator's stop");
    } else if (*times_.ending < 0) {
      object("the program died of signal " + std::to_string(-*times_.ending));
    }
  }

  void words() {
    const bool cannot_give_back = any([this](const Fault& fault) {
      const bool long_enough = fault.heals_after_s == 0.0 || fault.heals_after_s >= 1.0;
      const bool was_taken = any([&](const Fault& other) {  // the app holds control, so there is nothing to give back
        return other.reach == FaultReach::kTaken && struck_s(&other) < struck_s(&fault);
      });
      return fault.reach == FaultReach::kMute && long_enough && !was_taken && events_.client_flew_at(struck_s(&fault));
    });
    const bool spoke = times_.said.find("mode switch to P") != std::string::npos;
    if (case_.counted && times_.ending.value_or(-1) >= 0 &&
        times_.said.find("the thread that flies allocated 0 times in ") == std::string::npos) {
      const std::size_t at = times_.said.find("the thread that flies allocated");
      object(at == std::string::npos ? "no count of allocations was printed"
                                     : times_.said.substr(at, times_.said.find('\n', at) - at));
    }
    const bool log_ends = any([](const Fault& fault) { return fault.name.substr(0, 4) == "log "; });
    if (log_ends && times_.said.find("goes on without the rest of its log") == std::string::npos) {
      object("the log did not end, or the operator was not told");
    }
    if (cannot_give_back && !spoke && verdict_.returned_after_s > kStop_s) {  // otherwise the operator need not act
      object("the operator was not told what to do");
    }
    names();
  }

  /// Checks that the messages name the fault correctly.
  void names() {
    struct Word {
      std::string_view fault;
      Stage stage;
      std::string_view said;
    };
    constexpr std::array kWords{
        Word{"taken by the app", Stage::kFlying, "the mobile app has control of the aircraft, not the transmitter"},
        Word{"transmitter off", Stage::kFlying, "no transmitter is heard"},
        Word{"unplugged for 3 s", Stage::kStarting, "the port is gone; control is not ours"},
        Word{"the hold is over", Stage::kFlying, "because --hold is over"},
        Word{"second process killed", Stage::kFlying, "the second process is dead: nobody gives control back"},
        Word{"second process stopped", Stage::kFlying, "the second process hangs: nobody gives control back"},
        Word{"pose lost", Stage::kStarting, "control is not asked for yet; pose old"},
        Word{"pose lost, --once", Stage::kStarting, "control is not asked for yet; pose old"},
        Word{"pose frozen", Stage::kStarting, "control is not asked for yet; pose old"},
        Word{"pose port unplugged", Stage::kStarting, "control is not asked for yet; pose old"}};
    for (const Word& word : kWords) {
      if (case_.second == nullptr && case_.fault->name == word.fault && case_.stage == word.stage &&
          times_.said.find(word.said) == std::string::npos) {
        object("missing message to the operator: " + std::string(word.said));
      }
    }
  }

  const Case& case_;
  const FlightTimes& times_;
  const Events& events_;
  Verdict verdict_;
  double lag_s_ = 0.0;
};

}  // namespace

Verdict judge(const Case& flown, const FlightTimes& times, const Events& events) {
  return Judge(flown, times, events).judge();
}

}  // namespace m100::authority
