// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "firmware/model/axis_effect.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {

/// One number of a section: its key (with unit), its place in T and its permitted range.
template <typename T>
struct NumberKey {
  std::string_view key;
  double T::*member;
  double low;
  double high;
  bool only_if_set = false;  ///< not written at its default, so files older than the key keep their digest
};

/// A word of a file and what it stands for.
template <typename T>
struct NamedValue {
  std::string_view word;
  T value;
};
inline constexpr std::array kDeadZoneShapes{
    NamedValue<model::DeadZoneShape>{"continuous", model::DeadZoneShape::kContinuous},
    NamedValue<model::DeadZoneShape>{"jump", model::DeadZoneShape::kJump}};

/// The keys of an axis' section, from the table of axis effects, the scale first. The simulator's plant file uses the
/// same keys, so that a quantity has one name and one range.
std::span<const NumberKey<model::StickAxis>> axis_keys(model::AxisUnit unit);

std::span<const NumberKey<model::Translation>> translation_keys();
std::span<const NumberKey<model::MpcWeights>> mpc_keys();
std::span<const NumberKey<model::EstimatorNoise>> estimator_keys();
std::span<const NumberKey<model::AltitudeGains>> altitude_keys();
std::span<const NumberKey<model::YawGain>> yaw_keys();

}  // namespace m100::companion
