// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/unseen_log_flight.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host_tests/lab/logs/column_map.h"
#include "host_tests/unit/logs/memory_log.h"

namespace m100::host_tests {
namespace {

/// Interpolates a series between two steps.
double between(const std::vector<double>& series, double step) {
  const double inside = std::clamp(step, 0.0, static_cast<double>(series.size()) - 1.0);
  const auto whole = static_cast<std::size_t>(inside);
  const double part = inside - std::floor(inside);
  return series[whole] + part * (series[std::min(whole + 1, series.size() - 1)] - series[whole]);
}

double rounded(double value, double quantum) { return quantum > 0.0 ? quantum * std::round(value / quantum) : value; }

struct Flown {
  UnseenLogSticks sticks;
  std::vector<double> clean, air;
};

/// The sticks as sent at each step: hands move continuously, and a stick is sent at its own rate.
class SentSticks {
 public:
  SentSticks(const UnseenLogFlight& flight, UnseenLogRandom& rng)
      : every_s_(flight.stick_s),
        own_(flight.hand, flight.reach, flight.feedback, rng),
        other_(UnseenLogInput::kPilot, 100.0, 0.0, rng) {}

  void append(double t_s, double seen, UnseenLogSticks& sticks) {
    const double wanted = own_.next(t_s, seen);
    const double beside = other_.next(t_s, 0.0);
    if (t_s >= next_s_) {
      stick_ = std::round(wanted);
      second_ = std::round(beside);
      next_s_ += every_s_;
    }
    sticks.own.push_back(stick_);
    sticks.other.push_back(second_);
  }

 private:
  double every_s_;
  UnseenLogPilot own_, other_;
  double stick_ = 0.0, second_ = 0.0, next_s_ = 0.0;
};

/// Coloured disturbance by the air.
class UnseenLogAir {
 public:
  UnseenLogAir(const UnseenLogFlight& flight, UnseenLogRandom& rng)
      : noise_(flight.noise.air),
        keep_(std::exp(-kUnseenLogStep_s / flight.noise.air_s)),
        air_(noise_ * rng.normal()) {}
  double now() const { return share_ * air_; }
  void set_parameters(double share) { share_ = share; }
  void step(UnseenLogRandom& rng) { air_ = keep_ * air_ + noise_ * std::sqrt(1.0 - keep_ * keep_) * rng.normal(); }

 private:
  double noise_, keep_, air_, share_ = 1.0;
};

Flown simulate(const UnseenLogFlight& flight, UnseenLogRandom& rng) {
  const auto steps = static_cast<std::size_t>(flight.duration_s / kUnseenLogStep_s);
  Flown out;
  SentSticks hands(flight, rng);
  UnseenLogVehicle vehicle(flight.before);
  UnseenLogAir air(flight, rng);
  double own_mode = 0.0, seen = 0.0;
  bool changed = false;
  for (std::size_t k = 0; k < steps; ++k) {
    const double t_s = static_cast<double>(k) * kUnseenLogStep_s;
    if (!changed && t_s >= flight.change_s) {
      vehicle.set_parameters(flight.after);
      air.set_parameters(flight.air_later);
      changed = true;
    }
    hands.append(t_s, seen, out.sticks);
    const bool rests = t_s >= flight.rest_from_s && t_s < flight.rest_to_s;
    if (rests) {
      vehicle.stop();
    }
    double clean = vehicle.step(out.sticks, k);
    if (t_s >= flight.own_from_s && t_s < flight.own_to_s) {
      own_mode += (flight.before.gain * 100.0 * std::sin(0.9 * t_s) - own_mode) * kUnseenLogStep_s / 0.2;
      clean = own_mode;
    }
    out.clean.push_back(rests ? 0.0 : clean);
    out.air.push_back(rests ? 0.0 : air.now());
    seen = out.clean.back() + out.air.back();
    air.step(rng);
  }
  return out;
}

}  // namespace

lab::logs::FlightLog UnseenLogRows::log() const {
  const bool climb = axis == "climb";
  const std::string own_stick = climb ? "throttle" : axis;
  const std::string other_stick = climb ? "yaw" : axis == "roll" ? "pitch" : "roll";
  const std::string map = "time = \"t\"\n[signals]\nstick_" + own_stick + " = \"a\"\nstick_" + other_stick +
                          " = \"b\"\n" + (climb ? "velocity_z" : "attitude_" + axis) + " = \"c\"\n";
  const std::map<std::string, std::vector<double>> columns{{"t", time_s}, {"a", own}, {"b", other}, {"c", response}};
  return lab::logs::load(lab::logs::MemoryLog(columns), lab::logs::parse_column_map(map, "stranger.toml"));
}

UnseenLogSticks UnseenLogRecord::sticks_read_late(double late_s, double date_s) const {
  UnseenLogSticks out = sticks;
  const auto late = static_cast<std::ptrdiff_t>(late_s / kUnseenLogStep_s);
  const auto until =
      static_cast<std::ptrdiff_t>(std::min(date_s / kUnseenLogStep_s, static_cast<double>(out.own.size())));
  std::copy(sticks.own.begin() + late, sticks.own.begin() + std::max(until, late), out.own.begin());
  return out;
}

UnseenLogRecord UnseenLogRecord::inside(std::vector<std::pair<double, double>> train,
                                        const std::vector<std::pair<double, double>>& validate) const {
  train.insert(train.end(), validate.begin(), validate.end());
  UnseenLogRecord out;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const double t_s = rows.time_s[k];
    if (std::any_of(train.begin(), train.end(),
                    [&](const auto& range) { return t_s >= range.first && t_s < range.second; })) {
      out.clean.push_back(clean[k]);
      out.steps.push_back(steps[k]);
    }
  }
  return out;
}

UnseenLogFlight random_flight(UnseenLogRandom& rng) {
  UnseenLogFlight out;
  out.axis = rng.any_of<std::string>({"roll", "pitch", "climb"});
  const bool climb = out.axis == "climb";
  const double unit = climb ? 3.0e-3 : 9.0e-4;
  out.before.gain = unit * rng.between(0.75, 1.35);
  out.before.frequency_rad_s = rng.between(5.0, 12.0);
  out.before.damping = rng.between(0.45, 1.0);
  out.before.lag_s = rng.between(0.0, 0.015);
  out.before.delay_s = rng.any_of<double>({0.0, 0.015, 0.04, 0.09}) * rng.between(0.8, 1.2);
  out.before.dead_zone_counts = rng.one_in(2.5) ? rng.between(10.0, 25.0) : 0.0;
  out.before.trim_counts = rng.one_in(4.0) ? rng.sign() * rng.between(12.0, 35.0) : 0.0;
  out.hand = rng.any_of<UnseenLogInput>({UnseenLogInput::kPilot, UnseenLogInput::kPilot, UnseenLogInput::kSines,
                                         UnseenLogInput::kDoublets, UnseenLogInput::kHolds, UnseenLogInput::kBangBang,
                                         UnseenLogInput::kLoop});
  out.reach = rng.between(80.0, 200.0);
  out.feedback = rng.between(0.15, 0.4) / out.before.gain;
  out.duration_s = rng.any_of<double>({50.0, 60.0, 75.0, 90.0});
  out.stick_s = rng.any_of<double>({0.01, 0.02, 0.02});
  const double row_hz = rng.any_of<double>({10.0, 20.0, 25.0, 50.0, 50.0, 100.0, 100.0, 200.0, 400.0});
  out.noise.row_s = 1.0 / row_hz;
  out.noise.air = (climb ? 14.0 : 1.0) * std::exp(rng.between(std::log(0.0015), std::log(0.006)));
  out.noise.air_s = std::exp(rng.between(std::log(0.12), std::log(1.3)));
  out.quantum = rng.one_in(3.0) ? (climb ? 0.01 : 1e-3) : 0.0;
  out.noise.white = (climb ? 10.0 : 1.0) * rng.any_of<double>({2e-4, 1e-3, 2.5e-3});
  out.jitter = rng.one_in(3.0) ? rng.between(0.05, 0.25) : 0.0;
  return out;
}

UnseenLogRecord fly(const UnseenLogFlight& flight, UnseenLogRandom& rng) {
  const Flown flown = simulate(flight, rng);
  UnseenLogRecord out;
  out.rows.axis = flight.axis;
  const double last_s = flight.duration_s - 0.5;
  for (double next_s = 0.3; next_s < last_s;
       next_s += flight.noise.row_s * (1.0 + flight.jitter * rng.between(-1.0, 1.0))) {
    const auto step = static_cast<std::size_t>(next_s / kUnseenLogStep_s);
    const double at = static_cast<double>(step) + flight.response_early_s / kUnseenLogStep_s;
    const double clean = between(flown.clean, at);
    const double seen = clean + between(flown.air, at) + flight.noise.white * rng.normal();
    out.rows.time_s.push_back(static_cast<double>(step) * kUnseenLogStep_s);
    out.rows.own.push_back(flown.sticks.own[step]);
    out.rows.other.push_back(flown.sticks.other[step]);
    out.rows.response.push_back(rounded(seen, flight.quantum));
    out.clean.push_back(clean);
    out.steps.push_back(step);
  }
  out.sticks = flown.sticks;
  return out;
}

}  // namespace m100::host_tests
