// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/unseen_log.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>

#include "host_tests/property/identify/unseen_log_flight.h"

namespace m100::host_tests {
namespace {

using Shape = std::function<void(UnseenLogFlight&, UnseenLogRandom&, AdversarialLog&)>;
using Harm = std::function<void(UnseenLogRows&, UnseenLogRandom&, AdversarialLog&)>;

struct Kind {
  std::string name;
  Shape shape;
  Harm harm;
  bool of_attitude = false;  ///< roll and pitch only
};

const Harm kSound = [](UnseenLogRows&, UnseenLogRandom&, AdversarialLog&) {};

Shape healthy(const std::vector<UnseenLogInput>& hands) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    flight.hand = hands.empty() ? flight.hand : rng.any_of(hands);
    out.healthy = true;
  };
}

Shape finds(const std::string& what) {
  return [=](UnseenLogFlight&, UnseenLogRandom&, AdversarialLog& out) { out.finding = what; };
}

/// A parameter changes at a random time in the middle of the log.
Shape changes(const std::string& name, double UnseenLogParameters::*member, double low, double high, bool factor) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    flight.change_s = out.change_s = rng.between(0.2, 0.8) * flight.duration_s;
    flight.after = flight.before;
    const double size = rng.between(low, high);
    double& value = flight.after.*member;
    const bool either_way = member == &UnseenLogParameters::trim_counts;
    value = factor ? value * std::exp(rng.sign() * std::log1p(size)) : value + (either_way ? rng.sign() : 1.0) * size;
    out.change = name;
  };
}

/// An undeclared effect that is there throughout.
Shape lacks(const std::string& name, double UnseenLogParameters::*member, double low, double high, bool either_way) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    const double size = rng.between(low, high);
    const bool ratio = name == "gain_asymmetry" || name == "stick_curve";
    const double signed_size = (either_way ? rng.sign() : 1.0) * size;
    flight.before.*member = ratio ? std::exp(signed_size) : signed_size;
    out.effect = name;
  };
}

/// A limit of the command at a share of its usual size.
Shape limits(const std::string& name, double UnseenLogParameters::*member, bool rate) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    const double usual = flight.before.gain * flight.reach;
    flight.before.*member = usual * (rate ? 0.2 * flight.before.frequency_rad_s : 1.0) * rng.between(0.7, 1.0);
    out.effect = name;
  };
}

Shape clock(double low_s, double high_s) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    flight.before.delay_s = flight.before.lag_s = 0.0;  // so that the shift is the net delay
    flight.response_early_s = rng.between(low_s, high_s);
    out.finding = "clock_shift";
  };
}

void hold(std::vector<double>& column, const std::vector<double>& time_s, double from_s, double to_s) {
  double held = 0.0;
  bool holds = false;
  for (std::size_t k = 0; k < column.size(); ++k) {
    if (time_s[k] >= from_s && time_s[k] < to_s) {
      held = holds ? held : column[k];
      holds = true;
      column[k] = held;
    }
  }
}

/// Intervals in which a column does not change.
Harm freezes(bool stick) {
  return [=](UnseenLogRows& rows, UnseenLogRandom& rng, AdversarialLog& out) {
    std::vector<double>& column = stick ? rows.own : rows.response;
    const double row_s = (rows.time_s.back() - rows.time_s.front()) / static_cast<double>(rows.time_s.size());
    double to_s = rng.between(5.0, 12.0);
    for (int spell = 0; spell < (stick ? 1 : 4); ++spell) {
      const double from_s = to_s + (stick ? rng.between(5.0, 25.0) : rng.between(3.0, 8.0));
      to_s = from_s + (stick ? rng.between(3.0, 8.0) : std::max(8.0 * row_s, rng.between(0.3, 1.5)));
      hold(column, rows.time_s, from_s, to_s);
    }
    out.finding = "frozen";
  };
}

Harm outliers() {
  return [](UnseenLogRows& rows, UnseenLogRandom& rng, AdversarialLog& out) {
    const double unit = rows.axis == "climb" ? 4.0 : 1.0;
    const auto count = static_cast<double>(rows.response.size());
    for (int hit = 0; hit < 12; ++hit) {
      rows.response[static_cast<std::size_t>(rng.between(0.08, 0.95) * count)] +=
          rng.sign() * unit * rng.between(0.25, 1.5);
    }
    out.finding = "outliers";
  };
}

Harm scaled(double factor) {
  return [=](UnseenLogRows& rows, UnseenLogRandom&, AdversarialLog&) {
    for (double& value : rows.response) {
      value *= factor;
    }
  };
}

Shape on_the_ground(bool before) {
  return [=](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
    flight.hand = UnseenLogInput::kPilot;  // the pilot continues to move the stick
    const double so_long_s = rng.between(7.0, 12.0);
    flight.rest_from_s = before ? 0.0 : flight.duration_s - so_long_s;
    flight.rest_to_s = before ? so_long_s : 1e9;
    out.finding = "on_ground";
    out.usable = true;
  };
}

std::vector<Kind> healthy_kinds() {
  using enum UnseenLogInput;
  return {{"healthy, any hand", healthy({}), kSound},
          {"healthy, sharp sticks", healthy({kDoublets, kHolds, kBangBang}), kSound},
          {"healthy, closed loop", healthy({kLoop}), kSound},
          {"healthy, clock 20 to 80 ms late: a delay",
           [](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
             flight.response_early_s = -rng.between(0.02, 0.08);
             out.healthy = true;
           },
           kSound}};
}

std::vector<Kind> change_kinds() {
  return {
      {"gain changes 10 to 35 %", changes("gain", &UnseenLogParameters::gain, 0.10, 0.35, true), kSound},
      {"dead zone grows 10 to 25 counts",
       changes("dead_zone", &UnseenLogParameters::dead_zone_counts, 10.0, 25.0, false), kSound},
      {"frequency changes 20 to 60 %", changes("frequency", &UnseenLogParameters::frequency_rad_s, 0.2, 0.6, true),
       kSound},
      {"delay grows 20 to 80 ms", changes("transport_delay", &UnseenLogParameters::delay_s, 0.02, 0.08, false), kSound},
      {"trim changes 20 to 80 counts", changes("trim_offset", &UnseenLogParameters::trim_counts, 20.0, 80.0, false),
       kSound},
      {"air four times stronger later",
       [](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
         flight.change_s = rng.between(0.3, 0.7) * flight.duration_s;
         flight.after = flight.before;
         flight.air_later = 4.0;
         out.finding = "note";
         out.usable = true;
       },
       kSound}};
}

std::vector<Kind> effect_kinds() {
  return {{"lacks: dead zone", lacks("dead_zone", &UnseenLogParameters::dead_zone_counts, 12.0, 40.0, false), kSound},
          {"lacks: backlash", lacks("backlash", &UnseenLogParameters::backlash_counts, 10.0, 30.0, false), kSound},
          {"lacks: asymmetry", lacks("gain_asymmetry", &UnseenLogParameters::asymmetry, 0.2, 0.5, true), kSound},
          {"lacks: stick curve", lacks("stick_curve", &UnseenLogParameters::exponent, 0.15, 0.5, true), kSound},
          {"lacks: cross axis", lacks("cross_axis", &UnseenLogParameters::cross, 0.08, 0.3, true), kSound},
          {"lacks: gain drift", lacks("gain_drift", &UnseenLogParameters::drift_per_minute, 0.15, 0.4, true), kSound},
          {"lacks: lead zero", lacks("lead_zero", &UnseenLogParameters::lead_s, 0.06, 0.2, false), kSound},
          {"lacks: trim", lacks("trim_offset", &UnseenLogParameters::trim_counts, 20.0, 80.0, true), kSound},
          {"lacks: delay", lacks("transport_delay", &UnseenLogParameters::delay_s, 0.05, 0.15, false), kSound},
          {"lacks: saturation", limits("saturation", &UnseenLogParameters::saturation, false), kSound},
          {"lacks: rate limit", limits("rate_limit", &UnseenLogParameters::rate_limit_per_s, true), kSound}};
}

std::vector<Kind> log_kinds() {
  return {{"clock, net -20 to -60 ms", clock(0.02, 0.06), kSound},
          {"clock, net -10 ms", clock(0.01, 0.01), kSound},
          {"frozen samples", finds("frozen"), freezes(false)},
          {"frozen stick", finds("frozen"), freezes(true)},
          {"outliers", finds("outliers"), outliers()},
          {"attitude in degrees", finds("wrong_unit"), scaled(180.0 / std::numbers::pi), true},
          {"sign turned round", finds("sign_reversed"), scaled(-1.0)},
          {"sticks swapped", finds("swapped_axes"),
           [](UnseenLogRows& rows, UnseenLogRandom&, AdversarialLog&) { std::swap(rows.own, rows.other); }, true},
          {"landing inside the range", on_the_ground(false), kSound},
          {"take-off inside the range", on_the_ground(true), kSound},
          {"another mode for a while",
           [](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
             flight.own_from_s = rng.between(0.2, 0.7) * flight.duration_s;
             flight.own_to_s = flight.own_from_s + rng.between(6.0, 12.0);
             out.finding = "note";
           },
           kSound},
          {"tether in climb",
           [](UnseenLogFlight& flight, UnseenLogRandom& rng, AdversarialLog& out) {
             flight.axis = "climb";
             flight.before.gain = 3.0e-3 * rng.between(0.75, 1.35);
             flight.before.spring_per_s = rng.between(0.5, 1.5);
             flight.before.tether_m = rng.between(-0.5, 0.5);
             flight.noise.air = rng.between(0.03, 0.08);
             out.finding = "position_force";
           },
           kSound}};
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kAll = [] {
    std::vector<Kind> all;
    for (const auto& part : {healthy_kinds(), change_kinds(), effect_kinds(), log_kinds()}) {
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }();
  return kAll;
}

/// Declares everything that the vehicle has, except the hidden effect.
void declare(const UnseenLogFlight& flight, AdversarialLog& out) {
  out.declared = {"second_order"};
  if (out.effect != "transport_delay") {
    out.declared.emplace_back("transport_delay");
  }
  if (flight.before.dead_zone_counts > 0.0 && out.effect != "dead_zone") {
    out.declared.emplace_back("dead_zone");
  }
  if (std::abs(flight.before.trim_counts) > 0.0 && out.effect != "trim_offset") {
    out.declared.emplace_back("trim_offset");
  }
}

/// The vehicle without the hidden effect; its lag is taken for delay.
UnseenLogParameters believed_of(const UnseenLogFlight& flight, const AdversarialLog& truth) {
  UnseenLogParameters out = flight.before;
  const UnseenLogParameters plain;
  for (const auto member :
       {&UnseenLogParameters::backlash_counts, &UnseenLogParameters::asymmetry, &UnseenLogParameters::exponent,
        &UnseenLogParameters::saturation, &UnseenLogParameters::rate_limit_per_s,
        &UnseenLogParameters::drift_per_minute, &UnseenLogParameters::cross, &UnseenLogParameters::lead_s,
        &UnseenLogParameters::spring_per_s, &UnseenLogParameters::lag_s}) {
    out.*member = plain.*member;
  }
  const auto known = [&](const char* name) {
    return std::find(truth.declared.begin(), truth.declared.end(), name) != truth.declared.end();
  };
  out.dead_zone_counts = known("dead_zone") ? out.dead_zone_counts : 0.0;
  out.trim_counts = known("trim_offset") ? out.trim_counts : 0.0;
  out.delay_s =
      known("transport_delay") ? std::max(0.0, out.delay_s + flight.before.lag_s - flight.response_early_s) : 0.0;
  return out;
}

void ask_for_parts(double duration_s, bool pieces, AdversarialLog& out) {
  constexpr double kPiece_s = 6.0;
  const double end_s = duration_s - 1.0;
  out.train.clear();
  out.validate.clear();
  if (!pieces) {
    out.train.emplace_back(2.0, 0.65 * duration_s);
    out.validate.emplace_back(0.65 * duration_s, end_s);
    return;
  }
  bool training = true;
  for (double from_s = 2.0; from_s + 3.0 < end_s; from_s += kPiece_s, training = !training) {
    (training ? out.train : out.validate).emplace_back(from_s, std::min(end_s, from_s + kPiece_s));
  }
}

}  // namespace

const std::vector<std::string>& unseen_log_kinds() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> out;
    std::transform(kinds().begin(), kinds().end(), std::back_inserter(out), [](const Kind& kind) { return kind.name; });
    return out;
  }();
  return kNames;
}

AdversarialLog unseen_log(const std::string& kind, std::uint64_t seed) {
  const auto found = std::find_if(kinds().begin(), kinds().end(), [&](const Kind& one) { return one.name == kind; });
  AdversarialLog out;
  out.kind = kind;
  UnseenLogRandom rng(seed * 64 + static_cast<std::uint64_t>(found - kinds().begin()));
  auto flight = std::make_shared<UnseenLogFlight>(random_flight(rng));
  while (found->of_attitude && flight->axis == "climb") {
    *flight = random_flight(rng);
  }
  found->shape(*flight, rng, out);
  out.axis = flight->axis;
  declare(*flight, out);
  const bool pieces = rng.one_in(2.0);
  auto record = std::make_shared<UnseenLogRecord>(fly(*flight, rng));
  found->harm(record->rows, rng, out);
  out.log = record->rows.log();
  ask_for_parts(flight->duration_s, pieces, out);
  if (!out.change.empty() || !out.effect.empty() || out.healthy || out.finding == "clock_shift" ||
      out.finding == "position_force") {
    // A shift, or a change of the delay, counts against rows that are read just before the stick's next sample, too.
    const bool shifts = out.finding == "clock_shift" || out.change == "transport_delay";
    out.evidence = [record, flight, shifts, believed = believed_of(*flight, out), declared = out.declared,
                    train = out.train, validate = out.validate] {
      UnseenLogNoise noise = flight->noise;
      noise.white = std::hypot(noise.white, flight->quantum / std::sqrt(12.0));  // rounding adds noise
      const UnseenLogRecord asked = record->inside(train, validate);
      const auto against = [&](const UnseenLogSticks& sticks) {
        return evidence_of(asked.clean, asked.steps, sticks, believed, declared, noise);
      };
      const double known = against(record->sticks);
      const double late_s = std::min(flight->stick_s, flight->noise.row_s);
      return shifts ? std::min(known, against(record->sticks_read_late(late_s, flight->change_s))) : known;
    };
  }
  return out;
}

}  // namespace m100::host_tests
