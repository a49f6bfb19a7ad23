// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "firmware/app/config.h"
#include "firmware/companion/ground_station/requests.h"
#include "firmware/model/vehicle.h"
#include "firmware/ref/trajectory.h"

namespace m100::companion {

/// The sources of a flight's parameters.
struct ParameterSource {
  const model::Vehicle& vehicle;
  const app::FlightConfig& config;
  ref::SpeedLimits goals;  ///< of the ways to goals
};

/// One number that a ground station may read: its name on the wire (at most 16 characters), unit and value.
struct ParameterEntry {
  std::string_view name;
  std::string_view unit;
  double (*value)(const ParameterSource& source);
};
/// All parameters, in the order of their indices.
std::span<const ParameterEntry> parameter_entries();

/// The name, as in parameter_entries(), of the parameter that a PARAM_SET would change; else "of unknown name".
std::string_view name_of(const mavlink::ParamSet& parameter);

/// Answers requests for the numbers of a flight (PARAM_REQUEST_LIST, PARAM_REQUEST_READ). They are read-only: PARAM_SET
/// of a known name is answered with the unchanged value. A whole list is sent at one parameter per tick. No heap.
class Parameters {
 public:
  static constexpr std::size_t kMaxParameters = 64;

  explicit Parameters(const ParameterSource& source);

  /// Ignores other requests.
  void receive(const Request& request, Replies& replies);
  /// Call it in every tick.
  void tick(Replies& replies);

 private:
  mavlink::ParamValue message(std::size_t index) const;

  std::array<float, kMaxParameters> values_{};
  std::size_t next_;  ///< next parameter of the list being sent; the number of parameters: none is
};

}  // namespace m100::companion
