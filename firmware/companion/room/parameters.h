// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/app/config.h"
#include "firmware/companion/room/requests.h"
#include "firmware/model/vehicle.h"
#include "firmware/ref/trajectory.h"

namespace m100::companion {

/// Where the parameters of a flight are taken from.
struct ParameterSource {
  const model::Vehicle& vehicle;
  const app::FlightConfig& config;
  ref::SpeedLimits goals;  ///< of the ways to goals
};

/// One number that a room may read: its name on the wire, at most 16 characters, and where it is.
struct ParameterRow {
  std::string_view name;
  std::string_view unit;
  double (*value)(const ParameterSource& source);
};
/// All of them, in the order of their indices.
std::span<const ParameterRow> parameter_rows();

/// The parameter that somebody would change, by a name of ours.
std::string_view name_of(const mavlink::ParamSet& wish);

/// The numbers that a flight believes and keeps, for whoever asks (PARAM_REQUEST_LIST, PARAM_REQUEST_READ). They can be
/// read and not written: PARAM_SET is answered with the value as it stays. A whole list goes out one a tick. No heap.
class Parameters {
 public:
  static constexpr std::size_t kMost = 64;

  explicit Parameters(const ParameterSource& source);

  /// Other requests are passed over.
  void hear(const Request& request, Replies& replies);
  /// In every tick.
  void tick(Replies& replies);

 private:
  mavlink::ParamValue message(std::size_t index) const;

  std::array<float, kMost> values_{};
  std::size_t next_;  ///< of the list that goes out; the number of parameters: none does
};

}  // namespace m100::companion
