// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/tuning/tune.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace m100::lab::gains {
namespace {

constexpr double kFineness = 1.05;
constexpr int kCoarse = 400;  ///< frequencies: enough to find a peak within a hundredth
constexpr std::array kRow{2.0, 4.0, 8.0, 12.0, 18.0, 27.0, 40.0, 80.0};

bool keeps_margins(const TunedMargins& kept) {
  return kept.stable && kept.peak_sensitivity <= kLargestPeakSensitivity && kept.delay_margin_s >= kFieldDelayMargin_s;
}

}  // namespace

TunedMargins margins_over(const model::Vehicle& believed, const std::vector<Structure>& structures) {
  TunedMargins kept;
  for (const Structure& structure : structures) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      const Margins margins = flown_margins_of(believed, structure.vehicle, axis, kVirtualRcTiming, kCoarse);
      kept.stable = kept.stable && margins.stable;
      kept.peak_sensitivity = std::max(kept.peak_sensitivity, margins.peak_sensitivity);
      kept.delay_margin_s = std::min(kept.delay_margin_s, margins.delay_margin_s);
    }
  }
  return kept;
}

Tuned tune(const model::Vehicle& believed, const std::vector<Structure>& structures,
           const std::function<double(const model::Vehicle& believed)>& hover_motion) {
  model::Vehicle tried = believed;
  const auto at = [&](double input) {
    model::flown_weights(tried).input = input;
    Tuned out{.weights = model::flown_weights(tried), .kept = margins_over(tried, structures)};
    out.motion_deg_s = hover_motion(tried);
    out.keeps_all = keeps_margins(out.kept) && out.motion_deg_s <= kLargestMotion_deg_s;
    return out;
  };
  // The first and so fastest weight of the series that keeps all limits; then bisection towards its faster neighbour.
  std::vector<Tuned> row;
  for (const double input : kRow) {
    row.push_back(at(input));
    if (row.back().keeps_all) {
      break;
    }
  }
  if (!row.back().keeps_all) {
    const bool any_calm =
        std::any_of(row.begin(), row.end(), [](const Tuned& one) { return one.motion_deg_s <= kLargestMotion_deg_s; });
    return *std::min_element(row.begin(), row.end(), [any_calm](const Tuned& a, const Tuned& b) {
      const auto rank = [any_calm](const Tuned& one) {
        return std::pair{!one.kept.stable || (any_calm && one.motion_deg_s > kLargestMotion_deg_s),
                         one.kept.peak_sensitivity};
      };
      return rank(a) < rank(b);
    });
  }
  Tuned best = row.back();
  double fast = row.size() == 1 ? kSmallestInputWeight : row[row.size() - 2].weights.input;
  while (best.weights.input > kFineness * fast) {
    const Tuned middle = at(std::sqrt(fast * best.weights.input));
    (middle.keeps_all ? best.weights.input : fast) = middle.weights.input;
    best = middle.keeps_all ? middle : best;
  }
  return best;
}

}  // namespace m100::lab::gains
