// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_telemetry.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr double kEarthRadius_m = 6371000.0;
constexpr double kHomeLatitude_rad = 47.3769 * core::kDegree_rad;
constexpr double kHomeLongitude_rad = 8.5417 * core::kDegree_rad;
constexpr double kHomeAltitude_m = 408.0;
constexpr double kGravity_m_s2 = 9.8066;
constexpr std::uint8_t kGoodGps = 5;
// From pitch_roll.csv and height.csv: intervals at zero last 0.5 and 1.8 s in the mean, drifting ones 0.4 and 2.9 s.
constexpr double kStretch_s = 1.2;
constexpr double kVelocityWalk_m_s = 0.4;  // per root of a second
constexpr double kBarometer_s = 30.0;
constexpr double kHeightReset_s = 60.0;

std::uint64_t slots_between(protocol::Rate rate) {
  switch (rate) {
    case protocol::Rate::k1Hz:
      return 100;
    case protocol::Rate::k10Hz:
      return 10;
    case protocol::Rate::k50Hz:
      return 2;
    case protocol::Rate::k100Hz:
      return 1;
    default:
      return 0;
  }
}

std::array<float, 3> floats(const core::Vector<double, 3>& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

core::Vector<double, 3> noisy(const core::Vector<double, 3>& v, double sigma, Random& random) {
  if (sigma == 0.0) {
    return v;
  }
  return v + sigma * core::Vector<double, 3>(random.normal(), random.normal(), random.normal());
}

core::Quaternion<double> noisy(const core::Quaternion<double>& q, double sigma, Random& random) {
  if (sigma == 0.0) {
    return q;
  }
  // q * (1, half a small rotation), renormalised
  const double x = 0.5 * sigma * random.normal(), y = 0.5 * sigma * random.normal(), z = 0.5 * sigma * random.normal();
  core::Quaternion<double> r{.w = q.w - q.x * x - q.y * y - q.z * z,
                             .x = q.x + q.w * x + q.y * z - q.z * y,
                             .y = q.y + q.w * y + q.z * x - q.x * z,
                             .z = q.z + q.w * z + q.x * y - q.y * x};
  const double length = std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
  return {r.w / length, r.x / length, r.y / length, r.z / length};
}

/// The assistant's rates, with this one in place of its 50 Hz.
N1Rates with_rate(N1Rates rates, double rate_hz) {
  const protocol::Rate rate = rate_hz == 1.0    ? protocol::Rate::k1Hz
                              : rate_hz == 10.0 ? protocol::Rate::k10Hz
                              : rate_hz == 50.0 ? protocol::Rate::k50Hz
                                                : protocol::Rate::k100Hz;
  std::replace(rates.begin(), rates.end(), protocol::Rate::k50Hz, rate);
  return rates;
}

}  // namespace

std::uint16_t due_items(const N1Rates& rates, std::uint64_t slot) {
  std::uint16_t items = 0;
  for (std::size_t item = 0; item < rates.size(); ++item) {
    const std::uint64_t every = slots_between(rates[item]);
    if (every != 0 && slot % every == 0) {
      items = static_cast<std::uint16_t>(items | 1U << item);
    }
  }
  return items;
}

protocol::Telemetry report(const VehicleState& state, std::uint32_t ticks, const N1SensorNoise& noise, Random& random) {
  protocol::Telemetry telemetry;
  telemetry.time.ticks = ticks;
  const core::Quaternion<double> q = core::flip_yz(noisy(state.rotation_wb, noise.attitude_rad, random));
  telemetry.attitude = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                        static_cast<float>(q.z)};
  const core::Vector<double, 3> force_b = noisy(state.specific_force_b_m_s2, noise.force_m_s2, random);
  telemetry.acceleration = floats(core::flip_yz(core::Vector<double, 3>(force_b / kGravity_m_s2)));
  telemetry.velocity_ned_m_s = floats(core::flip_yz(noisy(state.velocity_w_m_s, noise.velocity_m_s, random)));
  telemetry.velocity_status = 1;
  telemetry.angular_velocity_frd_rad_s = floats(core::flip_yz(noisy(state.rate_b_rad_s, noise.rate_rad_s, random)));
  const core::Vector<double, 3>& p = state.position_w_m;
  telemetry.position = {.latitude_rad = kHomeLatitude_rad + p.x() / kEarthRadius_m,
                        .longitude_rad = kHomeLongitude_rad - p.y() / (kEarthRadius_m * std::cos(kHomeLatitude_rad)),
                        .altitude_m = static_cast<float>(kHomeAltitude_m + p.z()),
                        .height_m = static_cast<float>(p.z()),
                        .gps_health = kGoodGps};
  telemetry.magnetometer = {static_cast<std::int16_t>(1000), 0, static_cast<std::int16_t>(1500)};
  telemetry.battery_percent = static_cast<std::uint8_t>(std::lround(state.battery_percent));
  return telemetry;
}

N1Estimator::N1Estimator(const N1SensorNoise& noise, std::uint64_t seed)
    : noise_(noise), random_(seed, "n1_senses"), barometer_(noise.height_drift_m, kBarometer_s) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    offset_b_m_s2_[i] = noise.force_offset_m_s2 * random_.normal();
  }
}

VehicleState N1Estimator::update(const VehicleState& truth, core::Duration passed) {
  VehicleState estimated = truth;
  const double step_s = core::seconds<double>(passed);
  add_accelerometer_errors(estimated);
  if (noise_.velocity_zero_share > 0.0) {
    estimate_velocity(truth, step_s, estimated);
  }
  if (noise_.height_drift_m > 0.0) {
    estimate_height(truth, step_s, estimated);
  }
  return estimated;
}

void N1Estimator::add_accelerometer_errors(VehicleState& estimated) {
  estimated.specific_force_b_m_s2 += offset_b_m_s2_;
  if (noise_.force_vibration_m_s2 > 0.0 && estimated.motors_on) {
    // The rotors turn far above 100 Hz, so sampling makes their vibration white.
    for (Eigen::Index i = 0; i < 3; ++i) {
      estimated.specific_force_b_m_s2[i] += noise_.force_vibration_m_s2 * random_.normal();
    }
  }
}

void N1Estimator::estimate_velocity(const VehicleState& truth, double step_s, VehicleState& estimated) {
  next_switch_s_ -= step_s;
  if (next_switch_s_ <= 0.0) {
    drifting_ = !drifting_;
    const double share = drifting_ ? 1.0 - noise_.velocity_zero_share : noise_.velocity_zero_share;
    next_switch_s_ = -2.0 * kStretch_s * share * std::log(1.0 - random_.uniform());
    from_w_m_s_ = truth.velocity_w_m_s;
    drift_w_m_s_.setZero();
  }
  const double climb_m_s = truth.velocity_w_m_s.z();
  if (drifting_) {
    for (Eigen::Index i = 0; i < 2; ++i) {
      drift_w_m_s_[i] += kVelocityWalk_m_s * std::sqrt(step_s) * random_.normal();
    }
    estimated.velocity_w_m_s = truth.velocity_w_m_s - from_w_m_s_ + drift_w_m_s_;
  } else {
    estimated.velocity_w_m_s.setZero();
  }
  estimated.velocity_w_m_s.z() = climb_m_s;
}

void N1Estimator::estimate_height(const VehicleState& truth, double step_s, VehicleState& estimated) {
  const double drift_m = barometer_.advance(step_s, random_);
  const bool landed = was_in_air_ && !truth.in_air;
  was_in_air_ = truth.in_air;
  if (landed || random_.uniform() < step_s / kHeightReset_s) {
    height_from_m_ += noise_.height_drift_m * random_.normal();
  }
  estimated.position_w_m.z() = truth.position_w_m.z() + drift_m + height_from_m_;
}

bool has_unknown_rate(const protocol::Message& message) {
  const auto items = message.value.first(std::min(message.value.size(), protocol::kTelemetryItemCount));
  return message.id == protocol::ids::kTelemetryFrequency &&
         std::any_of(items.begin(), items.end(), [](std::byte code) { return code > std::byte{5}; });
}

N1Telemetry::N1Telemetry(const N1Behaviour::Telemetry& how, const N1Rates& rates, const N1SensorNoise& noise,
                         std::uint64_t seed)
    : how_(how),
      rates_(with_rate(rates, how.rate_hz)),
      noise_(noise),
      estimator_(noise, seed),
      random_(seed, "n1_autopilot") {}

void N1Telemetry::set_rates(const protocol::TelemetryFrequency& wanted) {
  for (std::size_t item = 0; item < rates_.size() && how_.obeys_rates; ++item) {
    rates_[item] = wanted.rates[item] == protocol::Rate::kAsItIs ? rates_[item] : wanted.rates[item];
  }
}

std::optional<protocol::Telemetry> N1Telemetry::next(const VehiclePort& vehicle, std::uint32_t ticks,
                                                     core::TimePoint now) {
  constexpr core::Duration kSlot = std::chrono::milliseconds(10);
  const std::uint16_t items = due_items(rates_, slot_);
  ++slot_;
  if (items == 0 || now < silent_until_) {
    return std::nullopt;
  }
  protocol::Telemetry telemetry = report(estimator_.update(vehicle.estimated(), kSlot), ticks, noise_, random_);
  const double unit = N1Behaviour{}.telemetry.acceleration_unit_m_s2 / how_.acceleration_unit_m_s2;
  for (float& axis : telemetry.acceleration) {
    axis = static_cast<float>(static_cast<double>(axis) * unit);
  }
  telemetry.items = items;
  return telemetry;
}

}  // namespace m100::sim
