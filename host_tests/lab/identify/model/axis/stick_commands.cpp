// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/stick_commands.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/power_table.h"

namespace m100::lab::identify {
namespace {

using model::StickAxis;

constexpr std::size_t kMaxKept = 100'000;  ///< samples of a stretch; two results of an hour would take 6 MB

/// Whether both make the same commands from every stick: they differ at most in delay and dynamics.
bool same_commands(StickAxis a, const StickAxis& b) {
  a.time_constant_s = b.time_constant_s;
  a.natural_frequency_rad_s = b.natural_frequency_rad_s;
  a.damping_ratio = b.damping_ratio;
  a.lead_zero_s = b.lead_zero_s;
  a.transport_delay_s = b.transport_delay_s;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    for (const model::AxisNumber& number : effect.numbers) {
      a.*number.member = effect.of_response ? b.*number.member : a.*number.member;
    }
  }
  return a == b;
}

/// Whether both make the same counts before the gain: they differ at most in gain, asymmetry, delay and dynamics.
bool same_counts(StickAxis a, const StickAxis& b) {
  a.scale_per_count = b.scale_per_count;
  a.gain_asymmetry = b.gain_asymmetry;
  return same_commands(a, b);
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
  std::vector<double>& out = result.commands[stretch];
  if (std::exchange(result.known[stretch], char{1}) != 0) {
    return out;
  }
  const Stretch& around = stretches_[stretch];
  const Result& other = results_[&result == results_.data() ? 1 : 0];
  const bool shared = !other.known.empty() && other.known[stretch] != 0 && same_counts(other.axis, axis);
  auto& counts = result.counts[stretch];
  counts = shared ? other.counts[stretch] : nullptr;
  model::StickLaw<double, PowerTable> law(axis, data.period_s);
  out.resize(around.end - around.past);
  if (counts == nullptr) {
    std::transform(data.stick.begin() + static_cast<std::ptrdiff_t>(around.past),
                   data.stick.begin() + static_cast<std::ptrdiff_t>(around.end), out.begin(),
                   [&](double stick) { return law.curved(law.moved(stick)); });
    counts = keep_counts_ && out.size() < kMaxKept ? std::make_shared<const std::vector<double>>(out) : nullptr;
  }
  const std::vector<double>& curved = counts != nullptr ? *counts : out;
  if (law.ends_with_gain()) {
    std::transform(curved.begin(), curved.end(), out.begin(), [&](double each) { return law.gained(each); });
    return out;
  }
  const double since_s = data.since_begin_s(around.begin);  // a drift restarts with every flight
  for (std::size_t i = around.past; i < around.end; ++i) {
    const double t_s = since_s + data.period_s * (static_cast<double>(i) - static_cast<double>(around.begin));
    out[i - around.past] = law.from_curved(curved[i - around.past], data.other.empty() ? 0.0 : data.other[i], t_s);
  }
  return out;
}

void arrived_commands(const std::vector<double>& commands, const StickAxis& axis, double period_s, std::size_t first,
                      std::span<double> out) {
  const double delay = axis.transport_delay_s / period_s;
  const double whole = std::floor(delay);
  const double part = delay - whole;
  const double lead = axis.lead_zero_s / period_s;
  const auto arrived = [&](double newer, double older, double oldest) {
    const double now = newer + part * (older - newer);
    return now + lead * (now - (older + part * (oldest - older)));
  };
  const auto begin = static_cast<std::ptrdiff_t>(first) - static_cast<std::ptrdiff_t>(whole);
  const std::ptrdiff_t count = std::ssize(commands);
  const auto held = [&](std::ptrdiff_t i) {
    return commands[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, count - 1))];
  };
  const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(2 - begin, 0, std::ssize(out));
  const std::ptrdiff_t to = std::clamp(count - begin, from, std::ssize(out));
  const auto at_an_end = [&](std::ptrdiff_t i) {
    out[static_cast<std::size_t>(i)] = arrived(held(begin + i), held(begin + i - 1), held(begin + i - 2));
  };
  for (std::ptrdiff_t i = 0; i < from; ++i) {
    at_an_end(i);
  }
  for (std::ptrdiff_t i = to; i < std::ssize(out); ++i) {
    at_an_end(i);
  }
  for (std::ptrdiff_t i = from; i < to; ++i) {
    const auto at = static_cast<std::size_t>(begin + i);
    out[static_cast<std::size_t>(i)] = arrived(commands[at], commands[at - 1], commands[at - 2]);
  }
}

}  // namespace m100::lab::identify
