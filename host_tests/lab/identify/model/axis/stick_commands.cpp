// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/stick_commands.h"

#include <algorithm>
#include <utility>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/power_table.h"

namespace m100::lab::identify {
namespace {

using model::StickAxis;

/// Whether both make the same counts of every stick, before the gain.
bool same_counts(const StickAxis& a, const StickAxis& b) {
  return a.dead_zone_shape == b.dead_zone_shape && a.dead_zone_counts == b.dead_zone_counts &&
         a.trim_counts == b.trim_counts && a.stick_exponent == b.stick_exponent &&
         a.backlash_counts == b.backlash_counts;
}

/// The numbers of a stick axis that act on the command before delay and dynamics.
std::vector<double StickAxis::*> stick_parameters() {
  constexpr std::array kBehind{&StickAxis::time_constant_s,   &StickAxis::natural_frequency_rad_s,
                               &StickAxis::damping_ratio,     &StickAxis::lead_zero_s,
                               &StickAxis::transport_delay_s, &StickAxis::rate_limit_per_s};
  std::vector<double StickAxis::*> out{&StickAxis::command_slew_per_s};  // a variant of an effect
  model::for_each_axis_number([&](const model::AxisNumber& number) {
    if (std::find(kBehind.begin(), kBehind.end(), number.member) == kBehind.end()) {
      out.push_back(number.member);
    }
  });
  return out;
}

/// Whether both make the same commands from every stick.
bool same_commands(const StickAxis& a, const StickAxis& b) {
  static const std::vector<double StickAxis::*> kNumbers = stick_parameters();
  return a.dead_zone_shape == b.dead_zone_shape &&
         std::all_of(kNumbers.begin(), kNumbers.end(), [&](auto number) { return a.*number == b.*number; });
}

}  // namespace

StickCommands::Result& StickCommands::result_for(const StickAxis& axis) const {
  auto found = std::find_if(results_.begin(), results_.end(),
                            [&](const Result& one) { return !one.commands.empty() && same_commands(one.axis, axis); });
  if (found == results_.end()) {  // keep the result used last: a Jacobian returns to it for every column
    found = results_.begin() + (last_ == 0 ? 1 : 0);
    found->axis = axis;
    found->commands.resize(size());
    found->counts.resize(size());
    found->known.assign(size(), 0);
  }
  last_ = static_cast<std::size_t>(found - results_.begin());
  return *found;
}

const std::vector<double>& StickCommands::of(const AxisData& data, const StickAxis& axis, std::size_t stretch) const {
  Result& result = result_for(axis);
  if (std::exchange(result.known[stretch], char{1}) == 0) {
    const Result& other = results_[&result == results_.data() ? 1 : 0];
    const bool shared =
        keep_counts_ && !other.known.empty() && other.known[stretch] != 0 && same_counts(other.axis, axis);
    compute(data, stretches_[stretch], shared ? &other.counts[stretch] : nullptr, axis, result.counts[stretch],
            result.commands[stretch]);
  }
  return result.commands[stretch];
}

void StickCommands::compute(const AxisData& data, const Stretch& around, const std::vector<double>* known_counts,
                            const StickAxis& axis, std::vector<double>& counts, std::vector<double>& out) const {
  model::StickLaw<double, PowerTable> law(axis, data.period_s);
  if (known_counts != nullptr) {
    out = *known_counts;
  } else {
    out.resize(around.end - around.past);
    std::transform(data.stick.begin() + static_cast<std::ptrdiff_t>(around.past),
                   data.stick.begin() + static_cast<std::ptrdiff_t>(around.end), out.begin(),
                   [&](double stick) { return law.curved(law.moved(stick)); });
  }
  if (keep_counts_) {
    counts = out;
  }
  if (law.ends_with_gain()) {
    std::transform(out.begin(), out.end(), out.begin(), [&](double curved) { return law.gained(curved); });
    return;
  }
  const bool has_other = !data.other.empty();
  const double since_s = data.since_begin_s(around.begin);  // a drift restarts with every flight
  for (std::size_t i = around.past; i < around.end; ++i) {
    const double t_s = since_s + data.period_s * (static_cast<double>(i) - static_cast<double>(around.begin));
    double& at = out[i - around.past];
    at = law.from_curved(at, has_other ? data.other[i] : 0.0, t_s);
  }
}

}  // namespace m100::lab::identify
