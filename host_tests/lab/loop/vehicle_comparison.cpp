// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/vehicle_comparison.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/output/vehicle_update.h"

namespace m100::lab::loop {
namespace {

using model::AxisUnit;
using model::StickAxis;

AxisUnit unit_of(const std::string& channel) {
  return channel == "climb"      ? AxisUnit::kClimb_m_s
         : channel == "yaw_rate" ? AxisUnit::kYawRate_rad_s
                                 : AxisUnit::kTilt_rad;
}

StickAxis model::Vehicle::*axis_of(const std::string& channel) {
  return channel == "roll"    ? &model::Vehicle::roll
         : channel == "pitch" ? &model::Vehicle::pitch
         : channel == "climb" ? &model::Vehicle::climb
                              : &model::Vehicle::yaw_rate;
}

std::vector<std::string> declared_axis(const StickAxis& axis) {
  std::vector<std::string> out{axis.is_first_order() ? "first_order" : "second_order"};
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    if (model::is_base(effect) || effect.name == "tilt_limit") {  // its key is in [translation]
      continue;
    }
    const model::AxisNumber& first = effect.numbers[0];
    const bool brought = effect.name == "transport_delay" && axis.lead_zero_s != 0.0;  // the lead zero brings it
    if (axis.*first.member != first.neutral && !brought) {
      out.emplace_back(effect.name);
    }
  }
  return out;
}

std::vector<std::string> declared_translation(const model::Translation& translation) {
  std::vector<std::string> out{"rigid_body"};
  for (const model::TranslationEffect& effect : model::kTranslationEffects) {
    if (!effect.has_key() || effect.needs.thrust_set_point) {
      continue;
    }
    const auto parameters = std::span(effect.parameters).first(effect.parameter_count());
    if (std::any_of(parameters.begin(), parameters.end(), [&](const model::EffectParameter& one) {
          return model::number_of(translation, one.key) != one.neutral;
        })) {
      out.emplace_back(effect.name);
    }
  }
  return out;
}

/// The number of a channel that is an axis by its key in the vehicle file; null: there is none.
double StickAxis::*member_of(const std::string& channel, const std::string& key) {
  double StickAxis::*out = nullptr;
  model::for_each_axis_number([&](const model::AxisNumber& number) {
    out = number.file.key[static_cast<std::size_t>(unit_of(channel))] == key ? number.member : out;
  });
  return out;
}

/// Sets one number of the channel by its key in the vehicle file.
void set(model::Vehicle& vehicle, const std::string& channel, const std::string& key, double value) {
  if (channel == "translation") {
    vehicle.translation = vehicle.translation.with(key, value);
  } else if (double StickAxis::*const member = member_of(channel, key); member != nullptr) {
    vehicle.*axis_of(channel).*member = value;
  }
}

constexpr std::string_view kDeadZone = "dead_zone_counts";

model::DeadZoneShape shape_of(const model::Vehicle& vehicle, const std::string& channel) {
  return (vehicle.*axis_of(channel)).dead_zone_shape;
}

/// Resets a parameter to its believed value, a dead zone's width together with its shape, which changes its meaning.
void put_back(model::Vehicle& vehicle, const model::Vehicle& believed, const std::string& channel,
              const identify::Refitted& one) {
  set(vehicle, channel, one.parameter, one.believed);
  if (one.parameter == kDeadZone) {
    (vehicle.*axis_of(channel)).dead_zone_shape = shape_of(believed, channel);
  }
}

double number_of(const model::Vehicle& vehicle, const std::string& channel, const std::string& key) {
  if (channel == "translation") {
    return model::number_of(vehicle.translation, key);
  }
  double StickAxis::*const member = member_of(channel, key);
  return member == nullptr ? 0.0 : vehicle.*axis_of(channel).*member;
}

}  // namespace

std::vector<std::string> declared(const model::Vehicle& vehicle, const std::string& channel) {
  return channel == "translation" ? declared_translation(vehicle.translation)
                                  : declared_axis(vehicle.*axis_of(channel));
}

model::Vehicle with_channel(const model::Vehicle& believed, const model::Vehicle& found, const std::string& channel) {
  model::Vehicle out = believed;
  if (channel == "translation") {
    const double limit_rad = out.translation.tilt_limit_rad;  // common to roll and pitch
    out.translation = found.translation;
    out.translation.tilt_limit_rad = limit_rad;
    return out;
  }
  out.*axis_of(channel) = found.*axis_of(channel);
  if (channel == "roll" || channel == "pitch") {  // axes, weights and noises of a design were searched together
    out.design = out.robust = {};
  }
  if (found.translation.tilt_limit_rad != believed.translation.tilt_limit_rad) {
    out.translation.tilt_limit_rad = found.translation.tilt_limit_rad;
  }
  return out;
}

bool predicts_better(const model::Vehicle& believed, const model::Vehicle& found, const identify::UnseenFlight& flight,
                     const std::string& channel) {
  const double most = (1.0 - kMinGain);
  const double ahead = identify::error_at_1s(found, flight, channel);
  if (channel == "translation") {
    return ahead < most * identify::error_at_1s(believed, flight, channel);
  }
  const double likely = identify::innovations(found, flight, channel) + kMinLikelihoodRatio;
  for (const double later_s : {0.0, -kTickPhase_s, -0.5 * kTickPhase_s, 0.5 * kTickPhase_s, kTickPhase_s}) {
    model::Vehicle shifted = believed;
    double& delay_s = (shifted.*axis_of(channel)).transport_delay_s;
    delay_s = std::max(0.0, delay_s + later_s);
    if (!(ahead < most * identify::error_at_1s(shifted, flight, channel)) ||
        !(likely < identify::innovations(shifted, flight, channel))) {
      return false;
    }
  }
  return true;
}

std::vector<identify::Refitted> believed_and_found(const model::Vehicle& believed,
                                                   const identify::IdentifyResult& result, const std::string& channel,
                                                   const identify::UnseenFlight& flight, model::Vehicle& found) {
  constexpr double kMatters = 0.01;
  constexpr double kUndetermined = 1e-4;
  std::vector<identify::Refitted> out = identify::refitted(believed, result);
  const double best = identify::error_at_1s(found, flight, channel);
  const bool better = predicts_better(believed, found, flight, channel);
  for (identify::Refitted& one : out) {
    if (number_of(found, channel, one.parameter) == one.believed) {
      one.matters = false;
      continue;
    }
    model::Vehicle as_believed = found;
    put_back(as_believed, believed, channel, one);
    const double worse = identify::error_at_1s(as_believed, flight, channel) / best - 1.0;
    one.matters = better && one.matters && worse > kMatters;
    // If all refits end at the edge of a parameter's range, it has no interval. The interval of a dead zone's width is
    // not valid for another shape: sticks that jump over their dead zone do not show its width.
    const bool no_interval = !(one.found.high > one.found.low) ||
                             (one.parameter == kDeadZone && shape_of(found, channel) != shape_of(believed, channel));
    const bool speaks = no_interval ? better && worse > kMatters : std::abs(worse) >= kUndetermined;
    if (!speaks) {
      one.found = {one.believed, std::min(one.found.low, one.believed), std::max(one.found.high, one.believed)};
      put_back(found, believed, channel, one);
    }
  }
  return out;
}

}  // namespace m100::lab::loop
