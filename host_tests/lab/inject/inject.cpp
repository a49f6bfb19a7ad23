// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/inject/inject.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "firmware/model/axis_effects.h"
#include "firmware/model/paper.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/hidden/stick_response.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/join.h"

namespace m100::lab::hidden {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kG_m_s2 = 9.80665;

struct AxisOf {
  Signal stick, other, response;
};

AxisOf axis_of(const std::string& axis) {
  static const std::map<std::string, AxisOf> kAxes{
      {"roll", {Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll}},
      {"pitch", {Signal::kStickPitch, Signal::kStickRoll, Signal::kAttitudePitch}},
      {"yaw_rate", {Signal::kStickYaw, Signal::kCount, Signal::kRateZ}},
      {"climb", {Signal::kStickThrottle, Signal::kCount, Signal::kVelocityZ}}};
  const auto found = kAxes.find(axis);
  if (found == kAxes.end()) {
    throw InputError("--axis", 0, axis, "roll, pitch, yaw_rate, climb or translation");
  }
  return found->second;
}

double parameter(const identify::ModelResult& fitted, const std::string& name, double otherwise) {
  for (const identify::NamedValue& value : fitted.parameters) {
    if (value.name == name) {
      return value.value;
    }
  }
  return otherwise;
}

/// The gain of StickPath's output [unit per count], from the fitted model. The model's gain is the mean of both sides
/// of an asymmetry, StickPath's that of one side; their stick curves are normalised at different travels.
double path_gain(const identify::ModelResult& fitted) {
  return parameter(fitted, "gain", 0.0) * 2.0 / (1.0 + parameter(fitted, "ratio", 1.0)) *
         std::pow(model::paper::kTravel_vrc / kTravel_counts, 1.0 - parameter(fitted, "exponent", 1.0));
}

/// The size of an effect that the model has and that is added: ratios multiply, an added limit replaces, all else adds.
double together(const model::AxisNumber& number, double own, double added) {
  return number.neutral > 0.0 ? own * added : number.logarithmic ? added : own + added;
}

/// The effects of the fitted model, except its delay, and `effects`; `delay_s` becomes the sum of both delays.
HiddenEffects joined(const identify::ModelResult& fitted, const HiddenEffects& effects, double& delay_s) {
  HiddenEffects all;
  delay_s = std::max(0.0, parameter(fitted, "delay_s", 0.0));
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    const model::AxisNumber& number = effect.numbers[0];
    const std::string name(effect.name);
    const auto added = effects.find(name);
    if (name == "transport_delay") {
      delay_s += added == effects.end() ? 0.0 : added->second;
    } else if (!model::is_base(effect)) {
      const double own = parameter(fitted, std::string(number.parameter), number.neutral);
      const double value = added == effects.end() ? own : together(number, own, added->second);
      if (value != number.neutral) {
        all[name] = value;
      }
    }
  }
  if (fitted.dead_zone_shape == "jump") {
    all["dead_zone_jump"] = std::exchange(all["dead_zone"], 0.0);
  }
  if (const auto leak = all.find("cross_axis"); leak != all.end()) {
    leak->second *= parameter(fitted, "gain", 0.0) / path_gain(fitted);
  }
  return all;
}

std::vector<double> response(const FlightLog& log, const AxisOf& axis, const identify::ModelResult& fitted,
                             const HiddenEffects& effects) {
  double delay_s = 0.0;
  const HiddenEffects all = joined(fitted, effects, delay_s);
  StickPath path(all, delay_s);
  Tilt tilt{.scale_rad = path_gain(fitted),
            .frequency_rad_s = parameter(fitted, "natural_frequency_rad_s", 1.0),
            .damping = parameter(fitted, "damping_ratio", 1.0),
            .time_constant_s = parameter(fitted, "time_constant_s", 0.0)};
  const auto& stick = log.of(axis.stick);
  const std::vector<double> none;
  const auto& other = axis.other == Signal::kCount ? none : log.of(axis.other);
  const int steps = static_cast<int>(std::lround(log.period_s / kStep_s));
  std::vector<double> out(log.size);
  for (std::size_t k = 0; k < log.size; ++k) {
    for (int i = 0; i < steps; ++i) {
      const double now_s = static_cast<double>(k) * log.period_s + i * kStep_s;
      const double counts = path.pass(stick[k], other.empty() ? 0.0 : other[k], now_s);
      tilt.step(tilt.scale_rad * counts, value_of(all, "lead_zero"), value_of(all, "rate_limit"),
                value_of(all, "saturation"));
    }
    out[k] = tilt.angle;
  }
  return out;
}

bool moves_the_aircraft(const std::string& name) {
  const model::TranslationEffect* effect = model::translation_effect(name);
  return effect != nullptr && effect->columns > 0 && effect->acts == model::Acts::kAsForce;
}

/// The effects' force over mass along x and y [m/s^2]: each value times its first column; periodic ones have 0.43 Hz.
std::pair<double, double> horizontal_force(const HiddenEffects& effects, const model::Moment& at) {
  constexpr double kLine_hz = 0.43;
  std::pair<double, double> sum{0.0, 0.0};
  for (const auto& [name, value] : effects) {
    const model::Acceleration column = model::translation_effect(name)->column(0, at, kLine_hz);
    sum.first += value * column[0];
    sum.second += value * column[1];
  }
  return sum;
}

void into_translation(FlightLog& log, const HiddenEffects& effects) {
  if (!log.has(Signal::kAttitudeRoll) || !log.has(Signal::kAttitudePitch) || !log.has3(Signal::kVelocityX)) {
    throw InputError(log.file, 0, "attitude_roll", "translation needs attitude and velocity");
  }
  auto& roll = log.of(Signal::kAttitudeRoll);
  auto& pitch = log.of(Signal::kAttitudePitch);
  for (std::size_t k = 0; k < log.size; ++k) {
    const double yaw = log.has(Signal::kAttitudeYaw) ? log.of(Signal::kAttitudeYaw)[k] : 0.0;
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    const double vx = log.of(Signal::kVelocityX)[k];
    const double vy = log.of(Signal::kVelocityY)[k];
    const auto [fx, fy] = horizontal_force(effects, {.time_s = log.time_s(k),
                                                     .air_velocity_w_m_s = {vx, vy, log.of(Signal::kVelocityZ)[k]},
                                                     .heading_cosine = c,
                                                     .heading_sine = s});
    const double thrust = log.has(Signal::kForceZ) ? log.of(Signal::kForceZ)[k] : kG_m_s2;
    // In the heading frame, b3 = (sin pitch cos roll, -sin roll, cos pitch cos roll).
    const double ahead = thrust * std::sin(pitch[k]) * std::cos(roll[k]) - (c * fx + s * fy);
    const double aside = -thrust * std::sin(roll[k]) - (-s * fx + c * fy);
    const double up = thrust * std::cos(pitch[k]) * std::cos(roll[k]);
    const double size = std::hypot(ahead, aside, up);
    const double old_roll = roll[k];
    const double old_pitch = pitch[k];
    roll[k] = -std::asin(aside / size);
    pitch[k] = std::atan2(ahead, up);
    if (log.has3(Signal::kForceX)) {
      // The same acceleration in the new attitude; the rotations are small, so roll and pitch are applied in sequence.
      auto& x = log.of(Signal::kForceX)[k];
      auto& y = log.of(Signal::kForceY)[k];
      auto& z = log.of(Signal::kForceZ)[k];
      const double about_pitch = pitch[k] - old_pitch;
      const double about_roll = roll[k] - old_roll;
      const double x0 = x;
      const double y0 = y;
      x = x0 * std::cos(about_pitch) - z * std::sin(about_pitch);
      const double z1 = z * std::cos(about_pitch) + x0 * std::sin(about_pitch);
      y = y0 * std::cos(about_roll) + z1 * std::sin(about_roll);
      z = z1 * std::cos(about_roll) - y0 * std::sin(about_roll);
    }
  }
}

}  // namespace

std::optional<model::Bounds> addable(const std::string& effect, const std::string& axis) {
  if (axis == "translation") {
    if (!moves_the_aircraft(effect)) {
      return std::nullopt;
    }
    const model::TranslationEffect& row = *model::translation_effect(effect);
    const bool searched_first = row.parameters[0].name.starts_with("frequency");
    const model::EffectParameter& number = row.parameters[searched_first ? 1 : 0];
    return model::Bounds{number.low, number.high};
  }
  const model::AxisUnit unit = axis == "yaw_rate" ? model::AxisUnit::kYawRate_rad_s
                               : axis == "climb"  ? model::AxisUnit::kClimb_m_s
                                                  : model::AxisUnit::kTilt_rad;
  const model::AxisEffect* row = model::axis_effect(effect);
  if (row == nullptr || row->typical.size == 0.0 || !StickPath::supports(effect) ||
      !row->numbers[0].file.exists(unit)) {
    return std::nullopt;
  }
  return row->numbers[0].file.range[static_cast<std::size_t>(unit)];
}

FlightLog inject(const FlightLog& log, const std::string& axis, const identify::ModelResult& fitted,
                 const HiddenEffects& effects) {
  for (const auto& [name, value] : effects) {
    if (!addable(name, axis)) {
      throw InputError("--effect", 0, name, "cannot be added to " + axis);
    }
  }
  FlightLog out = log;
  if (axis == "translation") {
    into_translation(out, effects);
    return out;
  }
  const AxisOf signals = axis_of(axis);
  for (const Signal needed : {signals.stick, signals.response}) {
    if (!log.has(needed)) {
      throw InputError(log.file, 0, std::string(name_of(needed)), "is needed to add an effect to " + axis);
    }
  }
  const std::vector<double> with = response(log, signals, fitted, effects);
  const std::vector<double> without = response(log, signals, fitted, {});
  std::vector<double>& y = out.of(signals.response);
  for (std::size_t k = 0; k < log.size; ++k) {
    y[k] += with[k] - without[k];
  }
  return out;
}

}  // namespace m100::lab::hidden
