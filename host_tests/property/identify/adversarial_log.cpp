// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/adversarial_log.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/property/identify/unseen_log_vehicle.h"

namespace m100::host_tests {
namespace {

using lab::logs::FlightLog;
using lab::logs::Signal;

using Maker = std::function<void(SyntheticAxis&, UnseenLogRandom&, AdversarialLog&)>;
using Harm = std::function<void(FlightLog&, UnseenLogRandom&, AdversarialLog&)>;

struct Kind {
  std::string name;
  Maker vehicle;
  Harm harm;
};

/// A property of the vehicle changes at a random time in the middle of the log.
Maker change(const std::string& named, const std::string& hidden, double low, double high, bool factor) {
  return [=](SyntheticAxis& vehicle, UnseenLogRandom& rng, AdversarialLog& out) {
    vehicle.change_s = out.change_s = rng.between(10.0, 36.0);
    const double size = rng.between(low, high);
    vehicle.hidden_later = vehicle.hidden;
    vehicle.hidden_later[hidden] = factor                    ? std::exp(rng.sign() * std::log1p(size))
                                   : hidden == "trim_offset" ? rng.sign() * size
                                                             : size;
    out.change_size = vehicle.hidden_later[hidden] - (factor ? 1.0 : 0.0);
    out.change = named;
  };
}

/// The stick is logged later than the vehicle's own delay, so that the response begins before it.
Harm early_response(double net_low_s, double net_high_s) {
  return [=](FlightLog& log, UnseenLogRandom& rng, AdversarialLog&) {
    const double earlier = (rng.between(net_low_s, net_high_s)) / log.period_s;
    std::vector<double>& stick = log.of(Signal::kStickRoll);
    const std::vector<double> old = stick;
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double at = std::max(0.0, static_cast<double>(k) - earlier);
      const auto whole = static_cast<std::size_t>(at);
      const double part = at - std::floor(at);
      stick[k] = old[whole] + part * (old[std::min(whole + 1, old.size() - 1)] - old[whole]);
    }
  };
}

Harm scaled(Signal signal, double factor) {
  return [=](FlightLog& log, UnseenLogRandom&, AdversarialLog&) {
    std::ranges::for_each(log.of(signal), [factor](double& value) { value *= factor; });
  };
}

Maker healthy() {
  return [](SyntheticAxis&, UnseenLogRandom&, AdversarialLog& out) { out.healthy = true; };
}

Maker finds(const std::string& what) {
  return [=](SyntheticAxis&, UnseenLogRandom&, AdversarialLog& out) { out.finding = what; };
}

Maker no_delay(const std::string& what) {
  return [=](SyntheticAxis& vehicle, UnseenLogRandom&, AdversarialLog& out) {
    vehicle.delay_s = 0.0;
    out.finding = what;
    out.healthy = what.empty();
    out.declared = {"second_order"};
  };
}

/// Healthy vehicles, and vehicles that change in flight.
std::vector<Kind> vehicle_kinds() {
  const Harm none = [](FlightLog&, UnseenLogRandom&, AdversarialLog&) {};
  return {
      {"healthy", healthy(), none},
      {"healthy, slow strong air",
       [](SyntheticAxis& vehicle, UnseenLogRandom& rng, AdversarialLog& out) {
         vehicle.air_rad = rng.between(0.006, 0.01);
         vehicle.air_time_s = rng.between(1.0, 2.5);
         out.healthy = true;
       },
       none},
      {"healthy, calm",
       [](SyntheticAxis& vehicle, UnseenLogRandom&, AdversarialLog& out) {
         vehicle.air_rad = 0.001;
         vehicle.sensor_rad = 0.0005;
         out.healthy = true;
       },
       none},
      {"healthy, no delay at all", no_delay(""), none},
      {"air three times stronger",
       [](SyntheticAxis& vehicle, UnseenLogRandom&, AdversarialLog& out) {
         vehicle.change_s = 30.0;
         vehicle.hidden_later["air"] = 3.0;
         out.finding = "note";
       },
       none},
      {"gain changes 10 to 25 %", change("gain", "gain", 0.10, 0.25, true), none},
      {"dead zone of 10 to 30 counts begins", change("dead_zone", "dead_zone", 10.0, 30.0, false), none},
      {"frequency changes 20 to 50 %", change("frequency", "frequency", 0.2, 0.5, true), none},
      {"delay grows 20 to 60 ms", change("transport_delay", "transport_delay", 0.02, 0.06, false), none},
      {"trim changes 15 to 50 counts", change("trim_offset", "trim_offset", 15.0, 50.0, false), none},
  };
}

/// Logs with a defect.
std::vector<Kind> log_kinds() {
  return {
      {"clock, net -20 to -60 ms", no_delay("clock_shift"), early_response(0.02, 0.06)},
      {"clock, net -10 ms", no_delay("clock_shift"), early_response(0.01, 0.01)},
      {"frozen samples", finds("frozen"),
       [](FlightLog& log, UnseenLogRandom& rng, AdversarialLog&) {
         std::vector<double>& roll = log.of(Signal::kAttitudeRoll);
         for (double from_s = rng.between(5.0, 9.0); from_s < 43.0; from_s += rng.between(4.0, 9.0)) {
           const std::size_t first = log.index_of(from_s);
           const std::size_t last = std::min(log.size, log.index_of(from_s + rng.between(0.2, 0.8)));
           std::fill(roll.begin() + static_cast<std::ptrdiff_t>(first),
                     roll.begin() + static_cast<std::ptrdiff_t>(last), roll[first]);
         }
       }},
      {"outliers", finds("outliers"),
       [](FlightLog& log, UnseenLogRandom& rng, AdversarialLog&) {
         std::vector<double>& roll = log.of(Signal::kAttitudeRoll);
         for (double at_s = rng.between(3.0, 5.0); at_s < 44.0; at_s += rng.between(0.5, 3.0)) {
           roll[log.index_of(at_s)] += rng.sign() * rng.between(0.2, 1.5);
         }
       }},
      {"sign of the stick", finds("sign_reversed"), scaled(Signal::kStickRoll, -1.0)},
      {"attitude in degrees", finds("wrong_unit"), scaled(Signal::kAttitudeRoll, 180.0 / std::numbers::pi)},
      {"roll and pitch swapped", finds("swapped_axes"),
       [](FlightLog& log, UnseenLogRandom&, AdversarialLog&) {
         std::swap(log.of(Signal::kStickRoll), log.of(Signal::kStickPitch));
       }},
  };
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = [] {
    std::vector<Kind> all = vehicle_kinds();
    std::ranges::move(log_kinds(), std::back_inserter(all));
    return all;
  }();
  return kKinds;
}

/// Whether the answer says that these data cannot separate the two effects.
bool stands_for(const lab::identify::IdentifyResult& result, const std::string& one, const std::string& other) {
  const auto holds = [](const std::vector<std::string>& group, const std::string& name) {
    return std::find(group.begin(), group.end(), name) != group.end();
  };
  return !other.empty() && std::any_of(result.not_separable.begin(), result.not_separable.end(),
                                       [&](const auto& group) { return holds(group, one) && holds(group, other); });
}

/// Whether an effect is named that is not there.
bool names_another(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  return std::any_of(result.effects.begin(), result.effects.end(), [&](const auto& effect) {
    return std::find(truth.named.begin(), truth.named.end(), effect.name) == truth.named.end() &&
           !(effect.name == truth.effect || stands_for(result, effect.name, truth.effect));
  });
}

/// Whether the change is named, near its time.
bool names_change(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  return std::any_of(result.changes.begin(), result.changes.end(), [&](const auto& one) {
    return one.name == truth.change && std::abs(one.at_s - truth.change_s) < 3.0;
  });
}

}  // namespace

const std::vector<std::string>& adversarial_log_kinds() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> out;
    for (const Kind& kind : kinds()) {
      out.push_back(kind.name);
    }
    return out;
  }();
  return kNames;
}

AdversarialLog adversarial_log(const std::string& kind, std::uint64_t seed) {
  const auto found = std::find_if(kinds().begin(), kinds().end(), [&](const Kind& one) { return one.name == kind; });
  AdversarialLog out;
  out.kind = kind;
  UnseenLogRandom rng(std::mt19937_64(seed * 6364136223846793005ULL + 1442695040888963407ULL));
  SyntheticAxis vehicle = SyntheticAxis::random(seed);
  found->vehicle(vehicle, rng, out);
  out.log = vehicle.fly();
  found->harm(out.log, rng, out);
  return out;
}

lab::identify::IdentifyResult identify_log(const AdversarialLog& truth, std::size_t refits,
                                           std::function<bool(lab::identify::SpecialTest)> may_act) {
  lab::identify::Request request;
  request.axis = truth.axis;
  request.declared = truth.declared;
  request.train = truth.train;
  request.validate = truth.validate;
  request.log = request.validation_log = &truth.log;
  request.refits = refits;
  request.may_act = std::move(may_act);
  return lab::identify::identify_axis(request);
}

namespace {

Classification judge_of_healthy(const std::string& verdict) {
  if (verdict == "nothing_missing") {
    return Classification::kRight;
  }
  return verdict == "unexplained" ? Classification::kFalseRejection : Classification::kWrongName;
}

}  // namespace

Classification classify(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  if (truth.healthy) {
    return judge_of_healthy(result.verdict);
  }
  const bool said = std::any_of(result.findings.begin(), result.findings.end(),
                                [&](const auto& finding) { return finding.what == truth.finding && finding.certain; });
  if (result.verdict == "nothing_missing") {
    return truth.usable && (said || truth.finding == "note") ? Classification::kRight
                                                             : Classification::kFalseAcceptance;
  }
  const bool named = truth.effect.empty() ? said : !result.effects.empty();
  const bool hit = truth.change.empty() ? named && result.changes.empty() : names_change(truth, result);
  if (hit && !names_another(truth, result)) {
    return Classification::kRight;
  }
  return result.verdict == "unexplained" ? Classification::kUndecided : Classification::kWrongName;
}

}  // namespace m100::host_tests
