// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/axis_family.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace m100::tools::identify {
namespace {

using Model = sysid::AxisModel<double>;

/// One free parameter: where it goes, how it is fitted, and in which units its box and starts are given.
struct Parameter {
  enum class Unit { kPlain, kStick, kCommand, kRate, kGain };
  const char* effect;
  const char* name;
  double Model::*member;
  bool logarithmic;
  Unit unit;
  double low, high;  ///< in `unit`
  double minimum;    ///< distance from `neutral` below which the effect means nothing, see big_enough
  double neutral;
};

using Unit = Parameter::Unit;
// Boxes are what an aircraft of any size could have; a fit that ends at a bound is no effect but a misfit.
constexpr std::array kParameters{
    Parameter{"first_order", "gain", &Model::gain, false, Unit::kGain, -8.0, 8.0, 0.0, 0.0},
    Parameter{"first_order", "time_constant_s", &Model::time_constant_s, true, Unit::kPlain, 0.005, 5.0, 0.0, 0.0},
    Parameter{"second_order", "gain", &Model::gain, false, Unit::kGain, -8.0, 8.0, 0.0, 0.0},
    Parameter{"second_order", "natural_frequency_rad_s", &Model::natural_frequency_rad_s, true, Unit::kPlain, 0.3,
              100.0, 0.0, 0.0},
    Parameter{"second_order", "damping_ratio", &Model::damping_ratio, true, Unit::kPlain, 0.05, 4.0, 0.0, 0.0},
    Parameter{"transport_delay", "delay_s", &Model::delay_s, false, Unit::kPlain, 0.0, 0.5, 0.015, 0.0},
    Parameter{"lead_zero", "zero_s", &Model::lead_zero_s, false, Unit::kPlain, 0.0, 1.0, 0.01, 0.0},
    Parameter{"lead_zero", "delay_s", &Model::delay_s, false, Unit::kPlain, 0.0, 0.5, 0.0, 0.0},
    Parameter{"dead_zone", "width_counts", &Model::dead_zone_counts, false, Unit::kStick, 0.0, 0.7, 4.0, 0.0},
    Parameter{"saturation", "limit", &Model::saturation, true, Unit::kCommand, 0.1, 3.0, 0.0, 0.0},
    Parameter{"tilt_limit", "limit_rad", &Model::tilt_limit, true, Unit::kCommand, 0.1, 4.0, 0.0, 0.0},
    Parameter{"tilt_limit", "other_gain", &Model::other_gain, true, Unit::kGain, 0.4, 3.0, 0.0, 0.0},
    Parameter{"rate_limit", "limit_per_s", &Model::rate_limit_per_s, true, Unit::kRate, 0.05, 6.0, 0.0, 0.0},
    Parameter{"gain_asymmetry", "ratio", &Model::gain_asymmetry, true, Unit::kPlain, 0.25, 4.0, 0.08, 1.0},
    Parameter{"trim_offset", "offset_counts", &Model::trim_counts, false, Unit::kStick, -0.7, 0.7, 6.0, 0.0},
    Parameter{"stick_curve", "exponent", &Model::stick_exponent, true, Unit::kPlain, 0.3, 4.0, 0.05, 1.0},
    Parameter{"backlash", "half_width_counts", &Model::backlash_counts, false, Unit::kStick, 0.0, 0.5, 3.0, 0.0},
    Parameter{"gain_drift", "fraction_per_minute", &Model::gain_drift_per_s, false, Unit::kPlain, -1.0, 1.0, 0.05, 0.0},
    Parameter{"cross_axis", "coefficient", &Model::cross_axis, false, Unit::kPlain, -2.0, 2.0, 0.02, 0.0},
};

/// Starts of an effect's new parameters, in their units; several parameters in a row per start.
struct Starts {
  const char* effect;
  std::vector<std::vector<double>> values;
  std::vector<const char*> variants;
};

const std::vector<Starts>& starts_table() {
  static const std::vector<Starts> table{
      {"first_order", {{1.0, 0.1}, {1.0, 0.4}}, {""}},
      {"second_order", {{1.0, 4.0, 0.7}, {1.0, 10.0, 0.7}, {1.0, 20.0, 0.9}}, {""}},
      {"transport_delay", {{0.03}, {0.1}, {0.2}}, {""}},
      {"lead_zero", {{0.05, 0.03}, {0.15, 0.08}, {0.1, 0.15}}, {""}},
      {"dead_zone", {{0.04}, {0.12}, {0.25}}, {"", "jump"}},
      {"saturation", {{0.45}, {0.7}, {0.9}}, {""}},
      {"tilt_limit", {{0.6, 1.0}, {0.9, 1.0}, {1.2, 1.0}}, {""}},
      {"rate_limit", {{0.5}, {0.9}}, {"", "slew"}},
      {"gain_asymmetry", {{1.0}}, {""}},
      {"trim_offset", {{0.0}}, {""}},
      {"stick_curve", {{1.0}, {1.5}}, {""}},
      {"backlash", {{0.03}, {0.12}}, {""}},
      {"gain_drift", {{0.0}}, {""}},
      {"cross_axis", {{0.0}}, {""}},
  };
  return table;
}

const Starts& starts_of(const std::string& effect) {
  const auto& table = starts_table();
  return *std::find_if(table.begin(), table.end(), [&](const Starts& s) { return effect == s.effect; });
}

bool has(const Structure& structure, const std::string& name) {
  return std::find(structure.begin(), structure.end(), name) != structure.end();
}

/// What a fit is chosen by. A variant (a jump at the dead zone's edge, say) must earn its place: a log whose sticks
/// leave out the dead zone, because a controller steps over it, fits with a jump of any width.
double cost(const Fit& fit) { return fit.shape.empty() ? fit.sum_of_squares : 1.02 * fit.sum_of_squares; }

bool has_token(const std::string& shape, const std::string& token) { return shape.find(token) != std::string::npos; }

double unit_of(const AxisScale& scale, Unit unit) {
  switch (unit) {
    case Unit::kStick:
      return scale.stick;
    case Unit::kCommand:
      return scale.response;
    case Unit::kRate:
      return scale.rate_per_s;
    case Unit::kGain:
      return scale.gain;
    case Unit::kPlain:
      break;
  }
  return 1.0;
}

// A parameter's place in the structure. The delay of a lead zero is the transport delay where there is one already.
std::vector<const Parameter*> parameters_of(const Structure& structure) {
  std::vector<const Parameter*> out;
  const bool delay_taken = has(structure, "transport_delay");
  for (const std::string& effect : structure) {
    for (const Parameter& parameter : kParameters) {
      const bool twice = delay_taken && effect == "lead_zero" && parameter.member == &Model::delay_s;
      if (effect == parameter.effect && !twice) {
        out.push_back(&parameter);
      }
    }
  }
  return out;
}

// Fitted number <-> number in the parameter's unit.
double to_fitted(const Parameter& parameter, double in_unit) {
  return parameter.logarithmic ? std::log(in_unit) : in_unit;
}
double from_fitted(const Parameter& parameter, double fitted) {
  return parameter.logarithmic ? std::exp(fitted) : fitted;
}

void put(Model& model, const Parameter& parameter, double physical) {
  model.*parameter.member = parameter.member == &Model::gain_drift_per_s ? physical / 60.0 : physical;
}

// The stick's quantile and slope quantiles of |values|.
double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) {
    return 0.0;
  }
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

AxisScale scale_of(const AxisBlocks& training) {
  const AxisData& data = training.data();
  std::vector<double> sticks;
  std::vector<double> responses;
  std::vector<double> rates;
  for (std::size_t number = 0; number < training.size(); ++number) {
    for (std::size_t i = training[number].begin; i < training[number].end; ++i) {
      sticks.push_back(std::abs(data.stick[i]));
      responses.push_back(std::abs(data.measured[i]));
      if (i >= training[number].begin + 6) {
        rates.push_back(std::abs(data.measured[i] - data.measured[i - 6]) / (6.0 * data.period_s));
      }
    }
  }
  AxisScale scale;
  scale.stick = std::max(quantile(sticks, 0.98), 1e-9);
  scale.response = std::max(quantile(responses, 0.98), 1e-9);
  scale.rate_per_s = std::max(quantile(rates, 0.99), 1e-9);
  scale.minimum_counts = scale.stick > 5.0 ? 1.0 : 1.0 / 660.0;
  // Gain by least squares at the lag that suits best.
  double best = -1.0;
  for (std::size_t lag = 0; lag <= 60; lag += 5) {
    double uy = 0.0;
    double uu = 0.0;
    for (std::size_t number = 0; number < training.size(); ++number) {
      for (std::size_t i = std::max(training[number].begin, lag); i < training[number].end; ++i) {
        uy += data.stick[i - lag] * data.measured[i];
        uu += data.stick[i - lag] * data.stick[i - lag];
      }
    }
    if (uu > 0.0 && uy * uy / uu > best) {
      best = uy * uy / uu;
      scale.gain = uy / uu;
    }
  }
  if (std::abs(scale.gain) < 1e-9 * scale.response / scale.stick) {
    scale.gain = scale.response / scale.stick;
  }
  return scale;
}

AxisFamily::AxisFamily(const AxisBlocks& training) : training_(training), scale_(scale_of(training)) {}

bool AxisFamily::knows(const std::string& name) {
  return std::any_of(kParameters.begin(), kParameters.end(),
                     [&](const Parameter& parameter) { return name == parameter.effect; });
}

std::vector<AxisFamily::ParameterName> AxisFamily::parameter_names(const Structure& structure) const {
  std::vector<ParameterName> out;
  for (const Parameter* parameter : parameters_of(structure)) {
    out.push_back({parameter->effect, parameter->name});
  }
  return out;
}

double AxisFamily::physical(const Fit& fit, std::size_t parameter) const {
  const Parameter& p = *parameters_of(fit.structure)[parameter];
  return from_fitted(p, fit.parameters[parameter]) * unit_of(scale_, p.unit);
}

sysid::AxisModel<double> AxisFamily::model(const Fit& fit) const {
  Model model;
  const std::vector<const Parameter*> parameters = parameters_of(fit.structure);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    put(model, *parameters[i], from_fitted(*parameters[i], fit.parameters[i]) * unit_of(scale_, parameters[i]->unit));
  }
  if (has_token(fit.shape, "jump")) {
    model.dead_zone_shape = model::DeadZoneShape::kJump;
  }
  if (has_token(fit.shape, "slew")) {
    model.command_slew_per_s = model.rate_limit_per_s;
    model.rate_limit_per_s = 0.0;
  }
  return model;
}

Fit AxisFamily::run(Fit start, std::span<const int> weights, int iterations) const {
  const std::vector<const Parameter*> parameters = parameters_of(start.structure);
  std::vector<sysid::Box> box;
  for (const Parameter* p : parameters) {
    // Steps small against what matters, large against the kinks of dead zone and play.
    box.push_back({to_fitted(*p, p->low), to_fitted(*p, p->high), p->member == &Model::delay_s ? 5e-4 : 2e-4});
  }
  std::size_t rows = 0;
  for (std::size_t block = 0; block < training_.size(); ++block) {
    rows += weights[block] > 0 ? samples_in(block) : 0;
  }
  std::vector<double> scratch((parameters.size() + 2) * rows);
  std::vector<double> x = start.parameters;
  const auto residual = [&](std::span<const double> at, std::span<double> out) {
    start.parameters.assign(at.begin(), at.end());
    training_.error(model(start), weights, out);
  };
  const sysid::LmReport report =
      sysid::levenberg_marquardt(residual, std::span<double>(x), box, rows, scratch, {iterations, 1e-4});
  start.parameters = x;
  start.sum_of_squares = report.sum_of_squares;
  start.free_parameters = parameters.size();
  return start;
}

double AxisFamily::sum_of_squares(const Fit& fit, std::span<const int> weights) const {
  std::size_t rows = 0;
  for (std::size_t block = 0; block < training_.size(); ++block) {
    rows += weights[block] > 0 ? samples_in(block) : 0;
  }
  std::vector<double> out(rows);
  training_.error(model(fit), weights, out);
  return std::inner_product(out.begin(), out.end(), out.begin(), 0.0);
}

Fit AxisFamily::with_jump(Fit fit, std::span<const int> weights) const {
  constexpr double kWidest = 0.6;
  constexpr double kStep = 0.02;
  constexpr double kFineStep = 0.002;
  const std::vector<const Parameter*> parameters = parameters_of(fit.structure);
  const auto width = std::find_if(parameters.begin(), parameters.end(),
                                  [](const Parameter* p) { return p->member == &Model::dead_zone_counts; });
  const auto at = static_cast<std::size_t>(width - parameters.begin());
  fit.shape += has_token(fit.shape, "jump") ? "" : "jump";
  const auto scan = [&](double from, double to, double step) {
    Fit best = fit;
    best.sum_of_squares = 0.0;
    for (double value = from; value <= to; value += step) {
      fit.parameters[at] = to_fitted(**width, value);
      fit.sum_of_squares = sum_of_squares(fit, weights);
      best = best.sum_of_squares > 0.0 && best.sum_of_squares <= fit.sum_of_squares ? best : fit;
    }
    return best;
  };
  fit = run(scan(kStep, kWidest, kStep), weights, 10);
  const double found = from_fitted(**width, fit.parameters[at]);
  return run(scan(std::max(kFineStep, found - kStep), found + kStep, kFineStep), weights, 15);
}

Fit AxisFamily::polish(const Fit& fit, std::span<const int> weights) const {
  Fit best = run(fit, weights, 15);
  if (has(fit.structure, "dead_zone")) {
    const Fit jump = with_jump(best, weights);
    best = cost(jump) < cost(best) ? jump : best;
  }
  const std::vector<const Parameter*> parameters = parameters_of(fit.structure);
  for (const std::string& effect : fit.structure) {
    const Starts& table = starts_of(effect);
    for (const char* variant : table.variants) {
      for (const std::vector<double>& values : table.values) {
        Fit start = best;
        for (const char* other : table.variants) {
          const std::string token(other);
          const std::size_t found = token.empty() ? std::string::npos : start.shape.find(token);
          if (found != std::string::npos) {
            start.shape.erase(found, token.size());
          }
        }
        start.shape += variant;
        std::size_t column = 0;
        for (std::size_t k = 0; k < parameters.size(); ++k) {
          if (effect == parameters[k]->effect && parameters[k]->member != &Model::gain) {
            start.parameters[k] = to_fitted(*parameters[k], values[std::min(column, values.size() - 1)]);
          }
          column += effect == parameters[k]->effect ? 1U : 0U;
        }
        const Fit tried = run(std::move(start), weights, 5);
        if (tried.sum_of_squares < 1.05 * best.sum_of_squares) {
          const Fit ended = run(tried, weights, 15);
          best = cost(ended) < cost(best) ? ended : best;
        }
      }
    }
  }
  return best;
}

Fit AxisFamily::fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const {
  const std::vector<const Parameter*> parameters = parameters_of(structure);
  Fit base;
  base.structure = structure;
  if (warm != nullptr && warm->structure == structure) {
    base.parameters = warm->parameters;
    base.shape = warm->shape;
    return run(base, weights, 6);
  }
  // What is known from `warm` stays; every effect that is new is started from each of its starts and variants.
  const std::vector<const Parameter*> known =
      warm != nullptr ? parameters_of(warm->structure) : std::vector<const Parameter*>{};
  std::vector<Fit> starts{base};
  if (warm != nullptr) {
    for (const char* token : {"jump", "slew"}) {
      const char* effect = std::string(token) == "jump" ? "dead_zone" : "rate_limit";
      if (has_token(warm->shape, token) && has(structure, effect)) {
        starts[0].shape += token;
      }
    }
  }
  for (const std::string& effect : structure) {
    std::vector<Fit> extended;
    const bool is_known = warm != nullptr && has(warm->structure, effect);
    const Starts& table = starts_of(effect);
    for (const Fit& start : starts) {
      for (const char* variant : is_known ? std::vector<const char*>{""} : table.variants) {
        for (std::size_t row = 0; row < (is_known ? 1 : table.values.size()); ++row) {
          Fit next = start;
          next.shape += variant;
          std::size_t column = 0;
          for (const Parameter* p : parameters) {
            if (effect != p->effect) {
              continue;
            }
            // The gain is the same quantity in both orders; a lead zero's delay starts at the transport delay.
            double value = to_fitted(*p, table.values[row][column++]);
            for (std::size_t k = 0; k < known.size(); ++k) {
              if (known[k]->member == p->member && (is_known || p->member == &Model::gain)) {
                value = warm->parameters[k];
              }
            }
            next.parameters.push_back(value);
          }
          extended.push_back(std::move(next));
        }
      }
    }
    starts = std::move(extended);
  }
  Fit best;
  for (const Fit& start : starts) {
    const Fit tried = run(start, weights, starts.size() > 1 ? 5 : 0);
    if (best.parameters.empty() || cost(tried) < cost(best)) {
      best = tried;
    }
  }
  best = run(best, weights, 25);
  if (has(structure, "dead_zone") && (warm == nullptr || !has(warm->structure, "dead_zone"))) {
    const Fit jump = with_jump(best, weights);
    return cost(jump) < cost(best) ? jump : best;
  }
  return best;
}

std::vector<double> AxisFamily::error(const Fit& fit, std::size_t block) const {
  std::vector<int> weights(training_.size(), 0);
  weights[block] = 1;
  return errors(fit, weights)[block];
}

std::vector<std::vector<double>> AxisFamily::errors(const Fit& fit, std::span<const int> weights) const {
  std::vector<double> flat(training_.samples());
  std::vector<int> ones(weights.size());
  std::transform(weights.begin(), weights.end(), ones.begin(), [](int weight) { return weight > 0 ? 1 : 0; });
  training_.error(model(fit), ones, flat);
  std::vector<std::vector<double>> out(training_.size());
  auto at = flat.begin();
  for (std::size_t block = 0; block < out.size(); ++block) {
    if (ones[block] > 0) {
      const auto next = at + static_cast<std::ptrdiff_t>(samples_in(block));
      out[block].assign(at, next);
      at = next;
    }
  }
  return out;
}

std::vector<Family::Edit> AxisFamily::edits(const Structure& present) const {
  std::vector<Edit> out;
  const bool has_other = !training_.data().other.empty();
  for (const Starts& entry : starts_table()) {
    const std::string name = entry.effect;
    if (name == "first_order" || has(present, name)) {
      continue;
    }
    if ((name == "tilt_limit" || name == "cross_axis") && !has_other) {
      continue;
    }
    if (name == "lead_zero" && !has(present, "second_order")) {
      continue;
    }
    if (name == "transport_delay" && has(present, "lead_zero")) {
      continue;
    }
    Structure next = present;
    if (name == "second_order") {
      next[0] = name;
    } else {
      next.push_back(name);
    }
    out.push_back({name, std::move(next)});
  }
  return out;
}

Structure AxisFamily::without(const Structure& structure, const std::string& name) const {
  Structure out = structure;
  if (name == "second_order") {
    if (!has(structure, "lead_zero")) {
      out[0] = "first_order";
    }
    return out;
  }
  out.erase(std::remove(out.begin() + 1, out.end(), name), out.end());
  return out;
}

bool AxisFamily::big_enough(const Fit& fit, const std::string& name) const {
  const std::vector<const Parameter*> parameters = parameters_of(fit.structure);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& p = *parameters[i];
    if (name != p.effect) {
      continue;
    }
    // An effect that ends at the edge of what an aircraft can have explains something else.
    const double in_unit = from_fitted(p, fit.parameters[i]);
    const double margin = 1e-3 * (p.high - p.low);
    if (in_unit > p.high - margin || (p.low != 0.0 && in_unit < p.low + margin)) {
      return false;
    }
    if (p.minimum <= 0.0) {
      continue;
    }
    const double value = physical(fit, i);
    const double distance = p.logarithmic ? std::abs(std::log(value / p.neutral)) : std::abs(value - p.neutral);
    const double least = p.unit == Unit::kStick ? p.minimum * scale_.minimum_counts : p.minimum;
    if (distance < least) {
      return false;
    }
    // A trim below what the air leaves anyway is the air's mean over this flight.
    if (p.member == &Model::trim_counts) {
      const double rmse = std::sqrt(fit.sum_of_squares / static_cast<double>(training_.samples()));
      if (distance * std::abs(physical(fit, 0)) < rmse) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace m100::tools::identify
