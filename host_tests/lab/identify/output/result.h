// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace m100::lab::identify {

// The result of `m100-lab identify`, the same for the stick axes and for translation: one field for each key of its
// JSON, and the series of the report. Units: rad (roll, pitch), rad/s (yaw_rate), m/s (climb), m/s^2 (translation).

/// Horizons of predictions [s], and the root mean square error at each.
inline constexpr std::array<double, 4> kHorizons_s{0.2, 0.5, 1.0, 2.0};
inline constexpr std::size_t kOneSecond = 2;  ///< index of 1 s
static_assert(kHorizons_s[kOneSecond] == 1.0);
using HorizonErrors = std::array<double, kHorizons_s.size()>;

/// A number and its 95 % interval: block jackknife, widened by the spread over structures that the log allows.
struct Interval {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

struct NamedInterval {
  std::string name;  ///< with its unit, e.g. "width_counts"
  Interval interval;
};

struct NamedValue {
  std::string name;
  double value = 0.0;
};

/// One structure fitted to the training part. Root mean squares are over blocks of 2.5 s: of the simulated response's
/// error, or of the predicted acceleration's (translation).
struct ModelResult {
  std::vector<std::string> structure;  ///< base model first, then effects
  std::vector<NamedValue> parameters;
  std::string dead_zone_shape;  ///< "continuous" or "jump" where the structure has a dead zone, declared or found
  double train_rmse = 0.0;
  double validation_rmse = 0.0;
  double fit_percent = 0.0;  ///< on the validation part
  HorizonErrors horizon_rmse{};
  HorizonErrors position_rmse{}, velocity_rmse{};  ///< translation, from the sticks (prediction.h); 0: not predicted
};

struct Rival {
  std::string name;
  double validation_rmse = 0.0;
  double cv_ratio = 1.0;  ///< its cross-validated mean square over the final model's
};

/// One accepted effect: its parameters in the final model, and the evidence by which it was accepted.
struct EffectResult {
  std::string name;
  std::vector<NamedInterval> parameters;
  std::string shape;                   ///< dead_zone: "continuous" or "jump"; empty elsewhere
  double validation_rmse_after = 0.0;  ///< of the final model without the effects accepted after it
  double cv_gain = 0.0;                ///< fraction of the cross-validated mean square it removes
  double delta_bic = 0.0;              ///< criterion without it minus criterion with it, effective sample size
  double paired_t = 0.0;               ///< over blocks
  std::vector<Rival> rivals;
};

/// One line of the candidate table: every single edit that was tried in a round, and the effects of accepted pairs.
struct CandidateRow {
  int round = 0;  ///< 0: first addition
  std::string name;
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double delta_white = 0.0;  ///< the criterion on whitened residuals
  double paired_t = 0.0;
  bool is_significant = false;
  bool accepted = false;
  bool winner = false;
};

struct Alignment {
  double stick_shift_samples = 0.0;  ///< by how many samples the reader moved the sticks later to match the response
  std::string evidence = "none";     ///< of the sticks: "sequence" or "none"
};

/// A finding about the log, the fit or the flight. `what` is one of these names:
/// sign_reversed, swapped_axes, wrong_unit, frozen, outliers, clock_shift, on_ground, gap, position_force, note.
struct Finding {
  std::string what = "note";
  std::string signal{};  ///< empty: no single signal
  double from_s = 0.0;
  double to_s = 0.0;   ///< equal to from_s: no time range
  std::string text{};  ///< a sentence
  bool certain = true;
};
/// If a finding of one of these kinds is certain, no number is fit to fly: the column map or the clock is wrong.
inline constexpr std::array<std::string_view, 4> kMisreadings{"sign_reversed", "swapped_axes", "wrong_unit",
                                                              "clock_shift"};
inline Finding note(std::string text) { return {.text = std::move(text)}; }

/// A change of one property of the vehicle within the log.
struct Change {
  double at_s = 0.0;
  double low_s = 0.0;  ///< 95 % interval of at_s
  double high_s = 0.0;
  std::string name;  ///< of an effect, or gain, frequency, damping, mass
  std::vector<NamedValue> parameters;
  std::optional<Interval> size;     ///< of a stick axis: after less before, 95 %
  std::vector<std::string> rivals;  ///< names that fit as well; empty: the name is certain
  double likelihood_ratio = 0.0;
};

/// A parameter of the believed model, and the value that the fit found.
struct Refitted {
  std::string parameter;
  double believed = 0.0;
  Interval found;
  bool matters = false;  ///< `believed` is outside `found` and far from it; in m100-lab loop it also predicts worse
};

/// What the final model leaves, as a function of one channel of the log (remainder.h).
struct RemainderCurve {
  std::string channel;    ///< e.g. "stick_roll", "battery"
  std::string unit;       ///< of the channel; empty: unknown
  std::string direction;  ///< of motion (translation): "x", ...
  bool is_gain = false;  ///< the command's gain changes with the channel, in shares of it; otherwise something is added
  double predicted = 0.0;    ///< share of the remainder's variance, on data unseen by the curve; below 0: nothing
  double chance = 0.0;       ///< the largest share that any curve reaches on a shifted remainder
  double after_first = 0.0;  ///< share that it predicts of what the first curve leaves; 0 without points
  std::vector<double> x{}, value{};      ///< the curve; empty: it is not among the first
  std::vector<double> low{}, high{};     ///< 95 %
  std::vector<double> mean_x{}, mean{};  ///< of groups with the same number of rows each
};

/// A series for a figure: one value per sample time; NaN where there is none.
struct Series {
  std::string name;  ///< e.g. "measured", "declared", "final", "declared_residual", "final_residual"
  std::vector<double> values;
};

struct Figures {
  std::vector<double> t_s;       ///< of all series below: the training blocks, then the validation blocks
  std::vector<char> validation;  ///< 1 where t_s lies in the validation part
  double sample_period_s = 0.0;  ///< of t_s inside of a range
  std::vector<Series> series;    ///< translation: "measured_x", "measured_y", ... one set per axis
  std::vector<double> lag_s;     ///< of the autocorrelations
  std::vector<double> declared_autocorrelation;
  std::vector<double> final_autocorrelation;
};

struct IdentifyResult {
  std::string axis;
  std::string stick_unit = "counts";  ///< of the axis' input; the names in JSON end in "_counts" for every unit
  ModelResult declared;
  std::vector<EffectResult> effects;
  ModelResult final_model;  ///< JSON key "final"
  std::vector<NamedInterval> final_intervals;
  double noise_floor = 0.0;
  Alignment alignment;
  std::vector<std::vector<std::string>> not_separable;
  std::vector<std::string> unexplained;
  std::string verdict;  ///< "nothing_missing", "explained" or "unexplained"
  std::vector<Finding> findings;
  std::vector<Change> changes;            ///< not repeated among the effects
  std::vector<Refitted> refitted;         ///< filled only where a believed vehicle file was given
  double validation_over_training = 0.0;  ///< ratio of the root mean squares of the final model
  std::vector<CandidateRow> candidates;
  std::vector<RemainderCurve> remainder;  ///< the largest share first
  Figures figures;
  double elapsed_s = 0.0;  ///< processor time of everything that led to this result
};

}  // namespace m100::lab::identify
