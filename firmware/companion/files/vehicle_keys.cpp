// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/vehicle_keys.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "firmware/model/axis_effects.h"

namespace m100::companion {
namespace {

using model::AltitudeGains;
using model::AxisUnit;
using model::EstimatorNoise;
using model::MpcWeights;
using model::StickAxis;
using model::Translation;
using model::YawGain;

/// The keys of one axis' section, in the order of the file.
std::vector<NumberKey<StickAxis>> keys_of(AxisUnit unit) {
  std::vector<std::pair<int, NumberKey<StickAxis>>> placed;
  model::for_each_axis_number([&](const model::AxisNumber& number) {
    const model::FileEntry& file = number.file;
    const auto at = static_cast<std::size_t>(unit);
    const int place = unit == AxisUnit::kTilt_rad ? file.place : file.place_of_rates;
    if (file.exists(unit)) {
      placed.push_back(
          {place,
           {file.key[at], number.member, file.range[at].low, file.range[at].high, place >= model::FileEntry::kLate}});
    }
  });
  std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<NumberKey<StickAxis>> keys;
  std::transform(placed.begin(), placed.end(), std::back_inserter(keys), [](const auto& one) { return one.second; });
  return keys;
}

constexpr auto kTranslationKeys = [] {
  std::array<NumberKey<Translation>, model::kTranslationNumbers.size()> keys{};
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const auto& from = model::kTranslationNumbers[k];
    keys[k] = {from.key, from.member, from.low, from.high, from.only_if_set};
  }
  return keys;
}();
constexpr std::array kMpcKeys{
    NumberKey<MpcWeights>{"position", &MpcWeights::position, 1e-3, 1e6},
    NumberKey<MpcWeights>{"velocity", &MpcWeights::velocity, 0.0, 1e6},
    NumberKey<MpcWeights>{"tilt", &MpcWeights::tilt, 0.0, 1e6},
    NumberKey<MpcWeights>{"input", &MpcWeights::input, 1e-3, 1e6},
    NumberKey<MpcWeights>{"input_rate", &MpcWeights::input_rate, 0.0, 1e6},
};
constexpr std::array kEstimatorKeys{
    NumberKey<EstimatorNoise>{"position_process_m", &EstimatorNoise::position_process_m, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"velocity_process_m_s", &EstimatorNoise::velocity_process_m_s, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"tilt_process_rad", &EstimatorNoise::tilt_process_rad, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"tilt_rate_process_rad_s", &EstimatorNoise::tilt_rate_process_rad_s, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"disturbance_process_m_s2", &EstimatorNoise::disturbance_process_m_s2, 1e-6, 10.0},
    NumberKey<EstimatorNoise>{"input_offset_process_rad", &EstimatorNoise::input_offset_process_rad, 1e-7, 1.0},
    NumberKey<EstimatorNoise>{"pose_position_sigma_m", &EstimatorNoise::pose_position_sigma_m, 1e-5, 1.0},
    NumberKey<EstimatorNoise>{"pose_velocity_sigma_m_s", &EstimatorNoise::pose_velocity_sigma_m_s, 1e-4, 5.0},
    NumberKey<EstimatorNoise>{"attitude_sigma_rad", &EstimatorNoise::attitude_sigma_rad, 1e-5, 0.5},
    NumberKey<EstimatorNoise>{"rate_sigma_rad_s", &EstimatorNoise::rate_sigma_rad_s, 1e-4, 5.0},
};
constexpr std::array kAltitudeKeys{
    NumberKey<AltitudeGains>{"proportional_per_s", &AltitudeGains::proportional_per_s, 0.0, 20.0},
    NumberKey<AltitudeGains>{"integral_per_s2", &AltitudeGains::integral_per_s2, 0.0, 50.0},
    NumberKey<AltitudeGains>{"derivative", &AltitudeGains::derivative, 0.0, 5.0},
    NumberKey<AltitudeGains>{"integral_min_m_s", &AltitudeGains::integral_min_m_s, -4.0, 0.0},
    NumberKey<AltitudeGains>{"integral_max_m_s", &AltitudeGains::integral_max_m_s, 0.0, 4.0},
    NumberKey<AltitudeGains>{"climb_limit_m_s", &AltitudeGains::climb_limit_m_s, 0.1, 4.0},
};
constexpr std::array kYawKeys{
    NumberKey<YawGain>{"proportional_per_s", &YawGain::proportional_per_s, 0.0, 20.0},
    NumberKey<YawGain>{"rate_limit_rad_s", &YawGain::rate_limit_rad_s, 0.05, 1.7453},
};

}  // namespace

std::span<const NumberKey<StickAxis>> axis_keys(AxisUnit unit) {
  static const std::array<std::vector<NumberKey<StickAxis>>, 3> kKeys{
      keys_of(AxisUnit::kTilt_rad), keys_of(AxisUnit::kYawRate_rad_s), keys_of(AxisUnit::kClimb_m_s)};
  return kKeys[static_cast<std::size_t>(unit)];
}
std::span<const NumberKey<Translation>> translation_keys() { return kTranslationKeys; }
std::span<const NumberKey<MpcWeights>> mpc_keys() { return kMpcKeys; }
std::span<const NumberKey<EstimatorNoise>> estimator_keys() { return kEstimatorKeys; }
std::span<const NumberKey<AltitudeGains>> altitude_keys() { return kAltitudeKeys; }
std::span<const NumberKey<YawGain>> yaw_keys() { return kYawKeys; }

}  // namespace m100::companion
