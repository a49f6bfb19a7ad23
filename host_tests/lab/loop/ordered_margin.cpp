// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/ordered_margin.h"

#include <algorithm>

namespace m100::lab::loop {
namespace {

constexpr double kWeightStep = 1.25;  ///< the delay margin grows by a few milliseconds a step
constexpr int kWeightSteps = 21;      ///< up to 87 times the weight: a loop too slow to hold a position in wind

bool keeps(const gains::TunedMargins& margins, const MarginOrder& order) {
  return margins.stable && margins.peak_sensitivity <= order.peak_sensitivity &&
         margins.delay_margin_s >= order.delay_margin_s;
}

}  // namespace

MarginOrder order_of(const model::Vehicle& first) {
  const gains::TunedMargins own = gains::margins_over(first, {{"its own model", first}});
  MarginOrder order;
  if (own.stable) {
    order.peak_sensitivity = std::max(order.peak_sensitivity, own.peak_sensitivity);
    order.delay_margin_s = std::min(order.delay_margin_s, own.delay_margin_s);
  }
  return order;
}

OrderedLaw at_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order) {
  OrderedLaw best{.vehicle = believed};
  double least_peak = 0.0;
  model::Vehicle tried = believed;
  for (int step = 0; step < kWeightSteps; ++step) {
    const gains::TunedMargins margins = gains::margins_over(tried, {{"the corrected model", truth}});
    if (keeps(margins, order)) {
      return {.vehicle = tried, .keeps = true};
    }
    if (margins.stable && (least_peak == 0.0 || margins.peak_sensitivity < least_peak)) {
      least_peak = margins.peak_sensitivity;
      best.vehicle = tried;
    }
    model::flown_weights(tried).input *= kWeightStep;
  }
  return best;
}

bool keeps_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order) {
  return keeps(gains::margins_over(believed, {{"the corrected model", truth}}), order);
}

Json margins_on(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order) {
  Json out;
  for (const auto& [name, axis] : {std::pair{"x", gains::Axis::kX}, {"y", gains::Axis::kY}}) {
    const gains::Margins margins = gains::flown_margins_of(believed, truth, axis, gains::kVirtualRcTiming);
    out[name] = {{"stable", margins.stable},
                 {"peak_sensitivity", margins.peak_sensitivity},
                 {"gain_margin", margins.gain_margin},
                 {"phase_margin_rad", margins.phase_margin_rad},
                 {"delay_margin_s", margins.delay_margin_s}};
  }
  out["ordered"] = keeps_ordered_margin(believed, truth, order);
  return out;
}

}  // namespace m100::lab::loop
