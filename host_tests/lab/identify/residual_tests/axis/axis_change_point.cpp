// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host_tests/lab/identify/model/axis/axis_structure.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"
#include "host_tests/lab/identify/residual_tests/change_scan.h"

namespace m100::lab::identify {
using model::StickAxis;

namespace {

constexpr double kWorthRefitting =
    14.0;  // a step of a dead zone is not linear: the scan sees less of it than the refit
/// A number that may change in flight (model::MidFlight), in the units of this log and fit.
struct Candidate {
  const model::MidFlight* change;
  FreeParameter free_parameter;
  double min_relevant = 0.0;  ///< in the parameter's unit
};

double positive(double value, double otherwise) { return std::abs(value) > 0.0 ? std::abs(value) : otherwise; }

/// Whether a whitened fit can move the parameter. The gain of the other stick and a dead zone with a jump are flat
/// between two stick positions. A trim is the fit's own offset of the response unless the command bends at the trim.
bool can_move(const AxisParameter& parameter, const std::vector<AxisParameter>& present, const Fit& fit) {
  const auto bends = [](const AxisParameter& p) {
    return p.is(&StickAxis::dead_zone_counts) || p.is(&StickAxis::stick_exponent) || p.is(&StickAxis::gain_asymmetry);
  };
  if (parameter.is(&StickAxis::trim_counts)) {
    return std::any_of(present.begin(), present.end(), bends);
  }
  const bool jump = parameter.is(&StickAxis::dead_zone_counts) && fit.shape.find("jump") != std::string::npos;
  return !jump && !parameter.is(&StickAxis::other_scale_per_count);
}

}  // namespace

std::vector<FreeParameter> free_parameters_of(const AxisFamily& family, const Fit& fit) {
  const StickAxis axis = family.model(fit);
  const double counts = family.scale().minimum_counts;
  std::vector<FreeParameter> out;
  const std::vector<AxisParameter> present = parameters_of(fit.structure);
  for (const AxisParameter& p : present) {
    if (!can_move(p, present, fit)) {
      continue;
    }
    const model::AxisNumber& number = *p.number;
    const bool slews = number.member == &StickAxis::rate_limit_per_s && fit.shape.find("slew") != std::string::npos;
    double StickAxis::*const member = slews ? &StickAxis::command_slew_per_s : number.member;
    const double scale = family.scale().of(number.unit);
    const double value = axis.*member;
    const bool in_counts = number.unit == model::AxisNumber::FitUnit::kStick;
    const double step = in_counts ? 2.0 * counts
                        : number.logarithmic || number.unit == model::AxisNumber::FitUnit::kGain
                            ? 0.02 * positive(value, 1e-6)
                            : 0.005 * std::abs(scale);
    const double a = family.scale().physical(number, number.fit.low);
    const double b = family.scale().physical(number, number.fit.high);
    out.push_back({std::string(number.parameter), member, step, std::min(a, b), std::max(a, b)});
  }
  return out;
}

namespace {

Candidate candidate_of(const model::AxisNumber& number, const StickAxis& axis, const AxisScale& scale) {
  const model::MidFlight& change = number.change;
  const bool stick = change.of == model::MidFlight::Of::kStick;
  const double plain = change.of == model::MidFlight::Of::kItself ? positive(axis.*number.member, 1e-9) : 1.0;
  const double fine = stick ? scale.minimum_counts : plain;
  return {.change = &change,
          .free_parameter = {.name = std::string(change.name),
                             .member = number.member,
                             .step = change.step * fine,
                             .low = stick ? scale.physical(number, change.low) : change.low * plain,
                             .high = stick ? scale.physical(number, change.high) : change.high * plain},
          .min_relevant = change.min_relevant * fine};
}

/// Every number that may change: those of the structure's own base model, and those of all effects, present or not.
std::vector<Candidate> candidates_of(const AxisFamily& family, const Fit& fit) {
  const StickAxis axis = family.model(fit);
  const std::vector<AxisParameter> present = parameters_of(fit.structure);
  std::vector<Candidate> out;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    for (const model::AxisNumber& number : effect.numbers) {
      const auto is_present = [&](const AxisParameter& one) { return one.is(number.member); };
      const auto is_known = [&](const Candidate& one) { return one.free_parameter.member == number.member; };
      const bool exists = !model::is_base(effect) || std::any_of(present.begin(), present.end(), is_present);
      if (!number.change.name.empty() && exists && std::none_of(out.begin(), out.end(), is_known)) {
        out.push_back(candidate_of(number, axis, family.scale()));
      }
    }
  }
  return out;
}

/// Derivative of the run's response by each free parameter.
Columns slopes(const FreeRun& run, const StickAxis& axis, const Rows& error,
               const std::vector<FreeParameter>& free_parameters) {
  Columns out(error.size(), static_cast<Eigen::Index>(free_parameters.size()));
  Eigen::Index column = 0;
  for (const FreeParameter& free_parameter : free_parameters) {
    StickAxis moved = axis;
    const double step = axis.*free_parameter.member + free_parameter.step <= free_parameter.high ? free_parameter.step
                                                                                                 : -free_parameter.step;
    moved.*free_parameter.member += step;
    out.col(column++) = (run.error(moved) - error) / step;
  }
  return out;
}

/// Smallest size of a change that is named. A delay must change by more than half a row of the stick and two standard
/// errors, because clocks that drift against each other shift it by up to half a row.
double min_of(const Candidate& candidate, const WhitenedFit& fit, double stick_row_s) {
  const bool delay = candidate.free_parameter.member == &StickAxis::transport_delay_s;
  return delay ? std::max({candidate.min_relevant, kMinDelayChange_s, 0.5 * stick_row_s + 2.0 * fit.sigmas.back()})
               : candidate.min_relevant;
}

/// Smallest size of a change that is reported as possible, without a name.
double min_doubted(const Candidate& candidate, const WhitenedFit& fit, const AxisData& data, double date_s) {
  constexpr double kErrors = 2.0;
  const bool delay = candidate.free_parameter.member == &StickAxis::transport_delay_s;
  const double error_s =
      std::hypot(fit.sigmas.back(), step_time_error_s(data, -1e9, date_s), step_time_error_s(data, date_s, 1e9));
  // The log may also begin to read other samples of the remote control, which shifts all steps by the same time.
  const double beat_s = is_stick_undersampled(data) ? std::min(AxisData::kSlowestStick_s, 0.5 * data.stick_row_s) : 0.0;
  return delay ? std::max({kMinDelayChange_s, beat_s + kErrors * fit.sigmas.back(), kErrors * error_s})
               : candidate.min_relevant;
}

struct TriedChange {
  const Candidate* candidate;
  ScanHit hit;
  WhitenedFit fit;
  bool dated = false;         ///< at_s is from simulated changes (date_again())
  bool turned_round = false;  ///< the response reverses, so the scan's time is meaningless and every time is tried
};

/// If the sign of the response reverses in flight, the fit over the whole log averages to a gain near zero, and its
/// dynamics are meaningless. The fits then start from gains of half the change, with opposite signs before and after
/// it, and from natural frequencies that an aircraft may have.
WhitenedFit fit_turned_round(const FreeRun& run, const StickAxis& axis,
                             const std::vector<FreeParameter>& free_parameters, const ParameterJump& change) {
  constexpr std::array<double, 3> kSpeeds_rad_s{3.0, 7.0, 14.0};
  constexpr double kDelay_s = 0.05;
  WhitenedFit best;
  best.score = std::numeric_limits<double>::infinity();
  for (const double speed_rad_s : kSpeeds_rad_s) {
    for (const double side : {-0.5, 0.5}) {
      StickAxis start = axis;
      ParameterJump turn = change;
      start.scale_per_count = side * std::abs(change.size);
      turn.size = -2.0 * start.scale_per_count;
      start.transport_delay_s = kDelay_s;
      if (start.is_first_order()) {
        start.time_constant_s = 1.0 / speed_rad_s;
      } else {
        start.natural_frequency_rad_s = speed_rad_s;
        start.damping_ratio = 0.7;
      }
      WhitenedFit fit = fit_whitened(run, start, free_parameters, &turn);
      if (fit.score < best.score) {
        best = std::move(fit);
      }
    }
  }
  return best;
}

/// Fits a change at the scan's time; a change of the gain by at least the gain itself also as a reversal.
TriedChange fit_with_break(const FreeRun& run, const StickAxis& axis, const std::vector<FreeParameter>& free_parameters,
                           Candidate& candidate, const ScanHit& hit) {
  const double size = hit.size(0);
  const ParameterJump change{candidate.free_parameter, hit.at_s, size};
  TriedChange out{&candidate, hit, fit_whitened(run, axis, free_parameters, &change)};
  const double gain = axis.scale_per_count;
  if (candidate.free_parameter.member != &StickAxis::scale_per_count || std::abs(size) < std::abs(gain)) {
    return out;
  }
  constexpr double kWide = 8.0;
  FreeParameter wide = candidate.free_parameter;
  wide.step = 0.02 * std::abs(size);
  wide.low = -kWide * std::abs(size);
  wide.high = kWide * std::abs(size);
  WhitenedFit again = fit_turned_round(run, axis, free_parameters, {wide, hit.at_s, size});
  if (again.score < out.fit.score && again.before.scale_per_count * again.after.scale_per_count < 0.0) {
    candidate.free_parameter = wide;
    candidate.min_relevant = 0.03 * std::abs(again.before.scale_per_count);
    out.fit = std::move(again);
    out.turned_round = true;
  }
  return out;
}

/// Possible times of the change, each with the power of the whitened residual, which is least at the likeliest time.
using PowerAt = std::vector<std::pair<double, double>>;

PowerAt powers(const FreeRun& run, const TriedChange& tried, double from_s, double to_s, double step_s) {
  const auto error_at = [&](double date_s) -> Rows {
    return run.error(tried.fit.before, tried.fit.after, date_s).array() - tried.fit.offset;
  };
  const Ar filter = autoregression(error_at(tried.hit.at_s), run.segments());
  PowerAt out;
  for (double date_s = from_s; date_s <= to_s; date_s += step_s) {
    Rows white = error_at(date_s);
    run.whiten_rows(filter, white);
    out.emplace_back(date_s, white.squaredNorm());
  }
  return out;
}

/// Sets the time of least power, and the interval of all times not clearly worse, with half a step on both sides.
void take_date(const PowerAt& powers, double rows, double step_s, ScanHit& hit) {
  constexpr double kDateDrop = 7.35;  // as in the scan
  const auto best =
      *std::min_element(powers.begin(), powers.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  hit.at_s = hit.low_s = hit.high_s = best.first;
  for (const auto& [date_s, power] : powers) {
    if (rows * std::log(power / best.second) < kDateDrop) {
      hit.low_s = std::min(hit.low_s, date_s - 0.5 * step_s);
      hit.high_s = std::max(hit.high_s, date_s + 0.5 * step_s);
    }
  }
}

/// Finds the time of the change more exactly. The scan finds when the response changes, which is later than the change
/// of the vehicle by its delay and dynamics. Here the vehicle is simulated with a change at each possible time. The
/// parameters before and after are kept meanwhile, so the interval is that of the time alone.
void date_again(const FreeRun& run, const std::vector<FreeParameter>& free_parameters, TriedChange& tried) {
  constexpr double kBefore_s = 2.0;
  constexpr double kAfter_s = 0.5;
  constexpr double kStep_s = 0.1;
  constexpr double kFineStep_s = 0.02;
  constexpr double kMaxDates = 120.0;
  const double count = whitened_rows(run.segments());
  const double first_s = run.time_s().front();
  const double last_s = run.time_s().back();
  double from_s = tried.turned_round ? first_s : std::max(first_s, tried.hit.low_s - kBefore_s);
  double to_s = tried.turned_round ? last_s : std::min(last_s, tried.hit.high_s + kAfter_s);
  for (int pass = tried.turned_round ? -1 : 0; pass < 2; ++pass) {
    const double step_s = std::max(pass <= 0 ? kStep_s : kFineStep_s, (to_s - from_s) / kMaxDates);
    take_date(powers(run, tried, from_s, to_s, step_s), count, step_s, tried.hit);
    from_s = std::max(from_s, tried.hit.low_s - step_s);
    to_s = std::min(to_s, tried.hit.high_s + step_s);
    const FreeParameter& free_parameter = tried.candidate->free_parameter;
    const ParameterJump change{free_parameter, tried.hit.at_s,
                               tried.fit.after.*free_parameter.member - tried.fit.before.*free_parameter.member};
    WhitenedFit again = fit_whitened(run, tried.fit.before, free_parameters, &change);
    if (again.score < tried.fit.score) {
      tried.fit = std::move(again);
    }
  }
  tried.dated = true;
}

/// Mean square of the innovations of the whole log over that of its noisier side, at most one. If turbulence grows
/// during the log, every change looks likelier than it is; so its likelihood ratio is multiplied by this.
double quiet_share(const FreeRun& run, const TriedChange& tried) {
  Rows white = run.error(tried.fit.before, tried.fit.after, tried.hit.at_s).array() - tried.fit.offset;
  run.whiten_rows(autoregression(white, run.segments()), white);
  std::array<double, 2> power{};
  std::array<double, 2> count{};
  for (std::size_t row = 0; row < run.size(); ++row) {
    const std::size_t side = run.time_s()[row] > tried.hit.at_s ? 1 : 0;
    power[side] += white(static_cast<Eigen::Index>(row)) * white(static_cast<Eigen::Index>(row));
    count[side] += 1.0;
  }
  const double noisier = std::max(power[0] / std::max(1.0, count[0]), power[1] / std::max(1.0, count[1]));
  const double whole = (power[0] + power[1]) / std::max(1.0, count[0] + count[1]);
  return noisier > 0.0 ? std::min(1.0, whole / noisier) : 1.0;
}

Change described(const TriedChange& tried) {
  const Candidate& candidate = *tried.candidate;
  Change out;
  out.at_s = tried.hit.at_s;
  out.low_s = tried.hit.low_s;
  out.high_s = tried.hit.high_s;
  out.name = candidate.free_parameter.name;
  out.parameters = {
      {"before" + std::string(candidate.change->suffix), tried.fit.before.*candidate.free_parameter.member},
      {"after" + std::string(candidate.change->suffix), tried.fit.after.*candidate.free_parameter.member}};
  constexpr double kTwoSided95 = 1.96;
  const double reach = kTwoSided95 * tried.fit.sigmas.back();
  const double size = out.parameters.back().value - out.parameters.front().value;
  out.size = Interval{size, size - reach, size + reach};
  return out;
}

void take(const TriedChange& tried, ChangePoint& out) {
  out.score = tried.fit.score;
  out.change = described(tried);
  out.free_parameter = tried.candidate->free_parameter;
  out.before = tried.fit.before;
  out.after = tried.fit.after;
}

/// The changes that the scan shows, each refitted at its time. @param steady  the fit without a change
std::vector<TriedChange> try_changes(const FreeRun& run, const WhitenedFit& steady,
                                     const std::vector<FreeParameter>& free_parameters,
                                     std::vector<Candidate>& candidates) {
  const StickAxis& axis = steady.before;
  const Rows error = run.error(axis);
  ScanRows rows{run.time_s(), run.segments(), -error, {}, run.weights()};
  const Columns own = slopes(run, axis, error, free_parameters);
  rows.base.resize(own.rows(), own.cols() + 1);
  rows.base << own, Columns::Ones(own.rows(), 1);

  std::vector<TriedChange> tried;
  for (Candidate& candidate : candidates) {
    ScanHit hit = scan_change(rows, slopes(run, axis, error, {candidate.free_parameter}));
    if (hit.likelihood_ratio < kWorthRefitting) {
      continue;
    }
    hit.at_s -= candidate.change->at_the_stick ? axis.transport_delay_s : 0.0;
    tried.push_back(fit_with_break(run, axis, free_parameters, candidate, hit));
    // The response changes later than the vehicle. If the refit at the scan's time is worse than the scan promised, the
    // time is searched again.
    if (steady.score - tried.back().fit.score < hit.likelihood_ratio) {
      date_again(run, free_parameters, tried.back());
    }
  }
  return tried;
}

}  // namespace

WhitenedFit unchanged_fit(const FreeRun& run, const AxisFamily& family, const Fit& fit) {
  return fit_to_convergence(run, family.model(fit), free_parameters_of(family, fit));
}

ChangePoint change_point(const FreeRun& run, const AxisFamily& family, const Fit& fit) {
  ChangePoint out;
  constexpr double kMin_s = 10.0;
  if (run.seconds() < kMin_s) {
    return out;
  }
  const std::vector<FreeParameter> free_parameters = free_parameters_of(family, fit);
  out.numbers = free_parameters.size();
  std::vector<Candidate> candidates = candidates_of(family, fit);
  // The structure fits the whole run as well as it can before anything is said to change.
  const WhitenedFit steady = fit_whitened(run, family.model(fit), free_parameters);
  std::vector<TriedChange> tried = try_changes(run, steady, free_parameters, candidates);
  const auto best = std::min_element(
      tried.begin(), tried.end(), [](const TriedChange& a, const TriedChange& b) { return a.fit.score < b.fit.score; });
  if (best == tried.end()) {
    return out;
  }
  // The autoregression of the fit without a change absorbs a step, so the scan's ratio is used if it is larger.
  const double ratio = quiet_share(run, *best) * std::max(steady.score - best->fit.score, best->hit.likelihood_ratio);
  const double size = best->fit.after.*best->candidate->free_parameter.member -
                      best->fit.before.*best->candidate->free_parameter.member;
  const bool little = std::abs(size) < min_of(*best->candidate, best->fit, family.stick_row_s());
  if (ratio < kCertainChange || little) {
    out.likely = ratio >= kLikelyChange &&
                 std::abs(size) >= min_doubted(*best->candidate, best->fit, run.data(), best->hit.at_s);
    take(*best, out);
    return out;
  }
  std::vector<std::string> rivals;
  for (const TriedChange& other : tried) {
    if (&other != &*best && other.fit.score < best->fit.score + kNameMargin) {
      rivals.push_back(other.candidate->free_parameter.name);
    }
  }
  if (!best->dated) {
    date_again(run, free_parameters, *best);
  }
  // The date is known only to within one row of the log or of the stick. For a change at the stick it is not known
  // either whether the date is that before or that after the transport delay.
  const double half_row_s = 0.5 * std::max(family.period_s(), family.stick_row_s());
  best->hit.low_s -= half_row_s;
  best->hit.high_s += half_row_s + (best->candidate->change->at_the_stick ? best->fit.after.transport_delay_s : 0.0);
  out.found = true;
  take(*best, out);
  out.change.rivals = rivals;
  out.change.likelihood_ratio = ratio;
  return out;
}

}  // namespace m100::lab::identify
