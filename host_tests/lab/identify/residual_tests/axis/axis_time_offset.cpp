// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/axis_time_offset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

using model::StickAxis;

constexpr double kEarliest_s = -0.2;
constexpr double kMargin = 6.0;  // of the likelihood ratio, for a certain net shift
constexpr double kMinSigmas = 3.0;
constexpr double kErrors = 2.0;
constexpr double kHalfOfTen_s = 0.005;  // a larger shift is nearer to -10 ms than to none

/// A first order as a second order of 60 rad/s with nearly the same motion; a second order is returned unchanged.
StickAxis second_order(StickAxis axis) {
  if (axis.is_first_order()) {
    axis.natural_frequency_rad_s = 60.0;
    axis.damping_ratio = 0.5 * axis.time_constant_s * axis.natural_frequency_rad_s;
    axis.time_constant_s = 0.0;
  }
  return axis;
}

std::vector<FreeParameter> free_parameters_of(const StickAxis& axis) {
  const double gain = std::abs(axis.scale_per_count);
  return {{"gain", &StickAxis::scale_per_count, 0.01 * gain, -8.0 * gain, 8.0 * gain},
          {"frequency", &StickAxis::natural_frequency_rad_s, 0.01 * axis.natural_frequency_rad_s, 0.3, 150.0},
          {"damping", &StickAxis::damping_ratio, 0.01 * axis.damping_ratio, 0.05, 80.0}};
}

/// The largest shift [s] that the unknown times of the stick's steps explain: the longest reading lag and two standard
/// errors of the steps' mean time, at least 5 ms.
double explained_shift_s(const AxisData& data) {
  const double own_s = std::min(AxisData::kSlowestStick_s, data.logged_stick_row_s());
  return std::max(kHalfOfTen_s, data.max_reading_lag_s(own_s) + kErrors * step_time_error_s(data, -1e9, 1e9));
}

/// Sets whether a shift is likely, certain, or explained by the rows of the stick.
/// @param likelier  whether a shift fits better than none
/// @param beyond  likelihood ratio over the largest shift that the unknown times of the stick's steps explain
void decide(const AxisData& data, bool likelier, double beyond, TimeOffset& out) {
  const double lag_s = data.max_reading_lag_s(data.logged_stick_row_s());
  const bool is_own = !is_stick_undersampled(data) && !(1.5 * data.logged_stick_row_s() < data.period_s);
  const bool exceeds =
      is_own ? out.shift_s < -std::max(kHalfOfTen_s, lag_s - kErrors * out.sigma_s) : beyond > kErrors * kErrors;
  out.certain = out.likelihood_ratio > kMargin && out.shift_s < -(lag_s + kMinSigmas * out.sigma_s);
  out.likely = out.certain || (likelier && exceeds);
  out.within_row = (out.likelihood_ratio > kMargin || out.zero_in_doubt) && !out.likely;
}

}  // namespace

TimeOffset time_offset(const FreeRun& run, const AxisFamily& family, const Fit& fit) {
  TimeOffset out;
  const StickAxis found = family.model(fit);
  const double period_s = std::max(family.period_s(), family.stick_row_s());
  constexpr double kClearDelay_s = 0.015;
  const bool has_zero = found.lead_zero_s > 0.0;
  const double net_s = has_zero ? 0.0 : found.transport_delay_s;
  constexpr double kMin_s = 5.0;
  if (net_s > std::max(period_s, kClearDelay_s) || run.seconds() < kMin_s) {
    return out;
  }
  const StickAxis start = second_order(found);
  const auto with = [&](double delay_s, double lead_s, double earliest_s, bool lead_free) {
    StickAxis from = start;
    from.transport_delay_s = delay_s;
    from.lead_zero_s = lead_s;
    std::vector<FreeParameter> free_parameters = free_parameters_of(from);
    free_parameters.push_back({"delay", &StickAxis::transport_delay_s, 0.002, earliest_s, 0.5});
    if (lead_free) {
      free_parameters.push_back({"zero", &StickAxis::lead_zero_s, 0.002, -0.02, 1.0});
    }
    return fit_whitened(run, from, free_parameters);
  };
  const auto power_at = [&](double delay_s) {
    StickAxis moved = start;
    moved.lead_zero_s = 0.0;
    moved.transport_delay_s = delay_s;
    return run.error(moved).squaredNorm();
  };
  const std::array<double, 5> starts{net_s, -0.03, -0.07, -0.11, -0.16};
  const double from_s =
      *std::min_element(starts.begin(), starts.end(), [&](double a, double b) { return power_at(a) < power_at(b); });
  constexpr std::size_t kDelay = 3;  // of the free parameters
  const WhitenedFit early = with(from_s, 0.0, kEarliest_s, false);
  const bool waits = early.values[kDelay] > -0.25 * period_s;  // no early response, with or without a zero
  if (waits && !(has_zero && early.values[kDelay] < 0.0)) {
    return out;
  }
  const WhitenedFit lead = with(0.0, std::max(0.01, found.lead_zero_s), 0.0, true);
  // The zero is one more parameter: a fit with it must be better by the penalty of Schwarz's criterion.
  const double price = std::log(static_cast<double>(run.size()));
  out.zero_in_doubt = has_zero && early.score < lead.score + price + kMargin;
  if (waits) {
    return out;
  }
  const WhitenedFit both = with(early.values[kDelay], 0.0, kEarliest_s, true);
  const WhitenedFit both_from_lead = with(lead.values[kDelay], lead.before.lead_zero_s, kEarliest_s, true);
  const WhitenedFit& free = both.score < both_from_lead.score ? both : both_from_lead;
  const WhitenedFit& best = early.score < free.score + price ? early : free;
  out.shift_s = best.values[kDelay];
  out.sigma_s = best.sigmas[kDelay];
  out.likelihood_ratio = lead.score - best.score;
  const bool likelier = lead.score + (&best == &early ? price : 0.0) > best.score;
  const double explained_s = explained_shift_s(run.data());
  const WhitenedFit late = with(-explained_s, best.before.lead_zero_s, -explained_s, &best == &free);
  decide(run.data(), likelier, late.score - best.score, out);
  return out;
}

std::string describe(const TimeOffset& clock) {
  return printed("the response begins %.3f s (+-%.3f) before its stick: %s", -clock.shift_s, 2.0 * clock.sigma_s,
                 clock.certain ? "the clocks disagree; the stick samples were shifted"
                               : "the clocks may disagree, but these data cannot confirm it");
}

}  // namespace m100::lab::identify
