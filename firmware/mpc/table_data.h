// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "firmware/mpc/gain_table.h"

namespace m100::mpc {

/// Calls visitor(name, numbers) for every number or array of numbers of a table, in the one order in which tables are
/// written as a list of doubles: into generated headers and into table files. The rows of a set-point law follow.
template <typename Table, typename Visitor>
constexpr void visit_numbers(Table& table, Visitor&& visitor) {
  visitor("states", table.states);
  visitor("input_min_rad", table.input_min_slope);
  visitor("input_max_rad", table.input_max_slope);
  visitor("tilt_sign", table.tilt_sign);
  visitor("acceleration_per_tilt", table.acceleration_per_tilt);
  visitor("drag_per_s", table.drag_per_s);
  visitor("input_gain", table.input_gain);
  visitor("rate_weight", table.rate_weight);
  visitor("position_taps", table.position_taps);
  visitor("velocity_taps", table.velocity_taps);
  visitor("tilt_taps", table.tilt_taps);
  visitor("input_taps", table.input_taps);
  visitor("terminal_velocity_taps", table.terminal_velocity_taps);
  visitor("terminal_tilt_taps", table.terminal_tilt_taps);
  visitor("state_gain", table.state_gain);
  visitor("disturbance_gain", table.disturbance_gain);
  visitor("tilt_target_gain", table.tilt_target_gain);
  visitor("input_target_gain", table.input_target_gain);
  visitor("filter_gain", table.filter_gain);
  visitor("hessian", table.hessian);
  visitor("inverse_hessian", table.inverse_hessian);
  visitor("clipping_gain", table.clipping_gain);
  visitor("delay.ticks", table.delay.ticks);
  visitor("delay.delay_s", table.delay.delay_s);
  visitor("delay.rest.transition", table.delay.rest.transition);
  visitor("delay.rest.input", table.delay.rest.input);
  visitor("delay.rest.disturbance", table.delay.rest.disturbance);
  visitor("delay.tick.transition", table.delay.tick.transition);
  visitor("delay.tick.input", table.delay.tick.input);
  visitor("delay.tick.disturbance", table.delay.tick.disturbance);
  visitor("delay.lead.zero_s", table.delay.lead.zero_s);
  visitor("delay.lead.rate_gain", table.delay.lead.rate_gain);
  visitor("delay.lead.jump", table.delay.lead.jump);
  visitor("delay.lead.share", table.delay.lead.share);
  visitor("setpoint.box", table.setpoint.box);
  visitor("setpoint.mirror", table.setpoint.mirror);
  visitor("setpoint.depth", table.setpoint.depth);
}

/// Number of doubles that visit_numbers() visits.
constexpr std::size_t count_numbers() {
  GainTable<double> table;
  std::size_t count = 0;
  visit_numbers(table, [&count](const char*, auto& numbers) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(numbers)>>) {
      ++count;
    } else {
      count += numbers.size();
    }
  });
  return count;
}
inline constexpr std::size_t kTableNumbers = count_numbers();

/// A table from its list of doubles, without the set-point law's rows.
template <typename T>
constexpr GainTable<T> table_of(std::span<const double, kTableNumbers> list, const core::Sha256Digest& vehicle) {
  GainTable<T> table;
  table.vehicle = vehicle;
  std::size_t next = 0;
  visit_numbers(table, [&list, &next](const char*, auto& numbers) {
    using Field = std::remove_cvref_t<decltype(numbers)>;
    if constexpr (std::is_arithmetic_v<Field>) {
      numbers = static_cast<Field>(list[next++]);
    } else {
      for (auto& number : numbers) {
        number = static_cast<typename Field::value_type>(list[next++]);
      }
    }
  });
  return table;
}

/// Converts constants from double to T.
template <typename T, std::size_t kCount>
constexpr std::array<T, kCount> rounded(const std::array<double, kCount>& numbers) {
  std::array<T, kCount> out{};
  for (std::size_t i = 0; i < kCount; ++i) {
    out[i] = static_cast<T>(numbers[i]);
  }
  return out;
}

}  // namespace m100::mpc
