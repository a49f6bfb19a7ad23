// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "firmware/model/axis_effect.h"

namespace m100::model {

namespace detail {
inline constexpr AxisNumber kScale{.parameter = "gain",
                                   .member = &StickAxis::scale_per_count,
                                   .field = "scale_per_count",
                                   .file = {{"scale_rad_per_count", "scale_rad_s_per_count", "scale_m_s_per_count"},
                                            {{{1e-5, 1e-2}, {1e-5, 1e-1}, {1e-5, 1e-1}}},
                                            1,
                                            1},
                                   .unit = AxisNumber::FitUnit::kGain,
                                   .fit = {-8.0, 8.0},
                                   .change = {.name = "gain",
                                              .of = MidFlight::Of::kItself,
                                              .step = 0.02,
                                              .low = -8.0,
                                              .high = 8.0,
                                              .min_relevant = 0.03,
                                              .at_the_stick = true}};
inline constexpr AxisNumber kDelay{
    .parameter = "delay_s",
    .member = &StickAxis::transport_delay_s,
    .file = {{"transport_delay_s", "transport_delay_s", "transport_delay_s"},
             {{{0.0, 0.3}, {0.0, 0.5}, {0.0, 0.5}}},
             5,
             5},
    .fit = {0.0, 0.5},
    .step = 5e-4,
    // Two clocks that drift against each other look like a change of the delay, by up to half the time between two rows
    // of the log.
    .change = {
        .name = "transport_delay", .suffix = "_s", .step = 0.005, .low = 0.0, .high = 0.6, .min_relevant = 0.008}};
/// Search for a change of a number that is never zero; step and bounds are relative to its value.
constexpr MidFlight relative(std::string_view name, std::string_view suffix, double step, double min_relevant) {
  return {.name = name,
          .suffix = suffix,
          .of = MidFlight::Of::kItself,
          .step = step,
          .low = 0.1,
          .high = 10.0,
          .min_relevant = min_relevant};
}
/// Search for a change of a number in stick counts; its bounds are shares of the largest deflection.
constexpr MidFlight in_counts(std::string_view name, double low, double high) {
  return {.name = name,
          .suffix = "_counts",
          .of = MidFlight::Of::kStick,
          .step = 4.0,
          .low = low,
          .high = high,
          .min_relevant = 4.0,
          .at_the_stick = true};
}
constexpr AxisNumber min_relevant(AxisNumber number, double min_relevant) {
  number.min_relevant = min_relevant;
  return number;
}
}  // namespace detail

/// Every effect that a stick axis may have, the two base models first. Vehicle and plant files, fits, reports,
/// forecasts and the choice of what is done in flight read this table. The law of an effect that changes the command is
/// in StickLaw (stick_axis.h).
inline constexpr std::array kAxisEffects{
    AxisEffect{.name = "first_order",
               .numbers = {detail::kScale, AxisNumber{.parameter = "time_constant_s",
                                                      .member = &StickAxis::time_constant_s,
                                                      .file = everywhere("time_constant_s", {0.005, 5.0}, 2, 2),
                                                      .fit = {0.005, 5.0},
                                                      .logarithmic = true,
                                                      .change = detail::relative("frequency", "_s", 0.03, 0.06)}},
               .starts = {{1.0, 0.1}, {1.0, 0.4}},
               .in_flight = InFlight::kInThePrediction},
    AxisEffect{.name = "second_order",
               .numbers = {detail::kScale,
                           AxisNumber{.parameter = "natural_frequency_rad_s",
                                      .member = &StickAxis::natural_frequency_rad_s,
                                      .file = everywhere("natural_frequency_rad_s", {0.5, 100.0}, 3, 3),
                                      .fit = {0.3, 100.0},
                                      .logarithmic = true,
                                      .change = detail::relative("frequency", "_rad_s", 0.02, 0.06)},
                           AxisNumber{.parameter = "damping_ratio",
                                      .member = &StickAxis::damping_ratio,
                                      .file = everywhere("damping_ratio", {0.05, 5.0}, 4, 4),
                                      .fit = {0.05, 4.0},
                                      .logarithmic = true,
                                      .change = detail::relative("damping", "", 0.03, 0.15)}},
               .starts = {{1.0, 4.0, 0.7}, {1.0, 10.0, 0.7}, {1.0, 20.0, 0.9}},
               .in_flight = InFlight::kInThePrediction,
               .sentence = "The axis overshoots or lags as a second-order system: estimator and prediction use it."},
    AxisEffect{.name = "transport_delay",
               .numbers = {detail::min_relevant(detail::kDelay, 0.015)},
               .starts = {{0.03}, {0.1}, {0.2}},
               .not_beside = "lead_zero",
               .typical = {0.05, Typical::Of::kBesideOwn},
               .in_flight = InFlight::kInThePrediction,
               .sentence = "Commands act late: the controller predicts the state through the delay."},
    AxisEffect{.name = "lead_zero",
               .numbers = {AxisNumber{.parameter = "zero_s",
                                      .member = &StickAxis::lead_zero_s,
                                      .file = everywhere("lead_zero_s", {-0.5, 0.5}, 6),
                                      .fit = {0.0, 1.0},
                                      .min_relevant = 0.01},
                           detail::kDelay},
               .starts = {{0.05, 0.03}, {0.15, 0.08}, {0.1, 0.15}},
               .needs = "second_order",
               .typical = {0.08, Typical::Of::kBesideOwn},
               .in_flight = InFlight::kInThePrediction,
               .sentence = "The autopilot anticipates the stick: the prediction carries the zero and its delay."},
    AxisEffect{.name = "dead_zone",
               .numbers = {AxisNumber{.parameter = "width_counts",
                                      .member = &StickAxis::dead_zone_counts,
                                      .file = everywhere("dead_zone_counts", {0.0, 300.0}, 7, 7),
                                      .unit = AxisNumber::FitUnit::kStick,
                                      .fit = {0.0, 0.7},
                                      .min_relevant = 4.0,
                                      .change = detail::in_counts("dead_zone", 0.0, 0.7)}},
               .starts = {{0.04}, {0.12}, {0.25}},
               .variant = "jump",
               .typical = {15.0, Typical::Of::kBesideOwn},
               .in_flight = InFlight::kInvertedAtTheStick,
               .sentence = "Small sticks are ignored: the stick map jumps over the zone instead of hanging in it."},
    AxisEffect{
        .name = "saturation",
        .numbers = {AxisNumber{
            .parameter = "limit",
            .member = &StickAxis::saturation,
            .field = "saturation",
            .file = {{"saturation_rad", "limit_rad_s", "limit_m_s"}, {{{0.0, 1.5}, {0.0, 20.0}, {0.0, 20.0}}}, 9, 10},
            .unit = AxisNumber::FitUnit::kCommand,
            .fit = {0.1, 3.0},
            .logarithmic = true}},
        .starts = {{0.45}, {0.7}, {0.9}},
        .typical = {0.8, Typical::Of::kLargestResponse},
        .sentence = "Large sticks do nothing more: the input limit of the controller must stay below it."},
    AxisEffect{
        .name = "tilt_limit",
        .numbers = {AxisNumber{.parameter = "limit_rad",
                               .member = &StickAxis::tilt_limit,
                               .unit = AxisNumber::FitUnit::kCommand,
                               .fit = {0.1, 4.0},
                               .logarithmic = true},
                    AxisNumber{.parameter = "other_gain",
                               .member = &StickAxis::other_scale_per_count,
                               .unit = AxisNumber::FitUnit::kGain,
                               .fit = {0.4, 3.0},
                               .logarithmic = true}},
        .starts = {{0.6, 1.0}, {0.9, 1.0}, {1.2, 1.0}},
        .needs_other_stick = true,
        .in_flight = InFlight::kInThePrediction,
        .sentence = "Both axes share one tilt limit: diagonal commands are cut; keep the combined limit below it."},
    AxisEffect{
        .name = "rate_limit",
        .numbers = {AxisNumber{.parameter = "limit_per_s",
                               .member = &StickAxis::rate_limit_per_s,
                               .field = "rate_limit_per_s",
                               .file = {{"rate_limit_rad_s", "rate_limit_rad_s2", "rate_limit_m_s2"},
                                        {{{0.0, 50.0}, {0.0, 100.0}, {0.0, 100.0}}},
                                        10,
                                        11},
                               .unit = AxisNumber::FitUnit::kRate,
                               .fit = {0.05, 6.0},
                               .logarithmic = true}},
        .starts = {{0.5}, {0.9}},
        .variant = "slew",
        .of_response = true,
        .typical = {0.6, Typical::Of::kFastestResponse},
        .sentence = "The axis turns no faster than the limit: large steps are slower than the linear model says."},
    AxisEffect{.name = "gain_asymmetry",
               .numbers = {AxisNumber{.parameter = "ratio",
                                      .member = &StickAxis::gain_asymmetry,
                                      .file = everywhere("gain_asymmetry", {0.2, 5.0}, 11, 12),
                                      .fit = {0.25, 4.0},
                                      .logarithmic = true,
                                      .min_relevant = 0.08,
                                      .neutral = 1.0}},
               .starts = {{1.0}},
               .typical = {1.2},
               .in_flight = InFlight::kInvertedAtTheStick,
               .sentence = "One direction answers more than the other: the stick map scales the two sides apart."},
    AxisEffect{.name = "trim_offset",
               .numbers = {AxisNumber{.parameter = "offset_counts",
                                      .member = &StickAxis::trim_counts,
                                      .file = everywhere("trim_counts", {-300.0, 300.0}, 8, 8),
                                      .unit = AxisNumber::FitUnit::kStick,
                                      .fit = {-0.7, 0.7},
                                      .min_relevant = 3.0,
                                      .change = detail::in_counts("trim_offset", -1.0, 1.0)}},
               .starts = {{0.0}},
               .in_every_model = true,
               .typical = {30.0},
               .in_flight = InFlight::kInvertedAtTheStick,
               .sentence = "The neutral stick does not balance: the stick map adds the trim, the observer watches it."},
    AxisEffect{.name = "stick_curve",
               .numbers = {AxisNumber{.parameter = "exponent",
                                      .member = &StickAxis::stick_exponent,
                                      .file = everywhere("stick_exponent", {0.3, 4.0}, 12, 9),
                                      .fit = {0.3, 4.0},
                                      .logarithmic = true,
                                      .min_relevant = 0.05,
                                      .neutral = 1.0}},
               .starts = {{1.0}, {1.5}},
               .typical = {1.3},
               .in_flight = InFlight::kInvertedAtTheStick,
               .sentence = "The stick law is curved: the stick map inverts it."},
    AxisEffect{.name = "backlash",
               .numbers = {AxisNumber{.parameter = "half_width_counts",
                                      .member = &StickAxis::backlash_counts,
                                      .file = everywhere("backlash_counts", {0.0, 200.0}, 13),
                                      .unit = AxisNumber::FitUnit::kStick,
                                      .fit = {0.0, 0.5},
                                      .min_relevant = 3.0}},
               .starts = {{0.03}, {0.12}},
               .typical = {15.0},
               .sentence = "The stick has play: expect a small limit cycle; the observer cannot remove it."},
    AxisEffect{
        .name = "gain_drift",
        .numbers = {AxisNumber{.parameter = "fraction_per_minute",
                               .member = &StickAxis::gain_drift_per_minute,
                               .file = everywhere("gain_drift_per_minute", {-1.0, 1.0}, 14),
                               .fit = {-1.0, 1.0},
                               .min_relevant = 0.05}},
        .starts = {{0.0}},
        .typical = {0.25},
        .sentence = "The gain changes over the flight (battery, temperature): identify again, watch the residual."},
    AxisEffect{.name = "cross_axis",
               .numbers = {AxisNumber{.parameter = "coefficient",
                                      .member = &StickAxis::cross_axis,
                                      .file = {{"cross_axis"}, {{{-1.0, 1.0}}}, 15},
                                      .fit = {-2.0, 2.0},
                                      .min_relevant = 0.02}},
               .starts = {{0.0}},
               .needs_other_stick = true,
               .typical = {0.15},
               .sentence = "The other axis leaks in: what is left appears as a disturbance."},
};  // kAxisEffects

/// The effect of that name, or nullptr.
constexpr const AxisEffect* axis_effect(std::string_view name) {
  for (const AxisEffect& effect : kAxisEffects) {
    if (effect.name == name) {
      return &effect;
    }
  }
  return nullptr;
}

/// Whether it is one of the two models that every other effect is added to.
constexpr bool is_base(const AxisEffect& effect) { return effect.numbers[0].member == &StickAxis::scale_per_count; }

/// Calls each(number) once for every member that has a row, in the order of the table.
template <typename Each>
constexpr void for_each_axis_number(Each&& each) {
  for (std::size_t i = 0; i < kAxisEffects.size(); ++i) {
    for (const AxisNumber& number : kAxisEffects[i].numbers) {
      bool first = true;
      for (std::size_t k = 0; k < i; ++k) {
        for (const AxisNumber& earlier : kAxisEffects[k].numbers) {
          first = first && earlier.member != number.member;
        }
      }
      if (first) {
        each(number);
      }
    }
  }
}

}  // namespace m100::model
