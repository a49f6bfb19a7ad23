// SPDX-License-Identifier: BSD-3-Clause
// Translation: from a log and a declared model to a verdict.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "host_tests/tools/identify/log_defects.h"
#include "host_tests/tools/identify/periodic.h"
#include "host_tests/tools/identify/request.h"
#include "host_tests/tools/identify/residual_test.h"
#include "host_tests/tools/identify/selection.h"
#include "host_tests/tools/identify/translation_family.h"
#include "host_tests/tools/input_error.h"

namespace m100::tools::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr std::size_t kLeastBlocks = 4;
constexpr double kMinimumCvGain = 0.03;  // the force residual has no memory: less is needed than on a stick axis
constexpr double kWeakShare = 0.25;     // of the mean square: what must be explained before a remainder to trust a name
constexpr double kMinimumShare = 0.14;  // three axes and a dozen channels: more chances to look predictable
constexpr double kMinimumMovedShare =
    0.25;                         // of velocity, which the residual itself moves: air that pushes looks like it
constexpr double kSwing = -0.45;  // an autocorrelation below this, later on, is a swing and no air
constexpr double kSwingFrom_s = 0.3;
const std::vector<double> kHorizons_s{0.2, 0.5, 1.0, 2.0};

std::string sentence(const char* format, double a, double b = 0.0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

/// One log with its ranges cut into blocks.
struct Part {
  Part(const FlightLog& of, const std::vector<Range>& ranges, Thrust thrust)
      : log(of), data(of, thrust), blocks(data, ranges), measured(TranslationFamily::measured(blocks)) {}
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  double rmse(const std::vector<double>& predicted) const {
    double sum = 0.0;
    for (std::size_t row = 0; row < measured.size(); ++row) {
      sum += (measured[row] - predicted[row]) * (measured[row] - predicted[row]);
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, measured.size())));
  }

  /// Rows of one axis in time order.
  std::vector<double> axis(const std::vector<double>& rows, std::size_t c) const {
    std::vector<double> out;
    for (const auto& block : blocks.blocks) {
      const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(block.row + c * block.samples.size());
      out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(block.samples.size()));
    }
    return out;
  }

  double fit_percent(const std::vector<double>& predicted) const {
    double error = 0.0;
    double spread = 0.0;
    for (std::size_t c = 0; c < data.axes; ++c) {
      const std::vector<double> y = axis(measured, c);
      const std::vector<double> p = axis(predicted, c);
      double mean = 0.0;
      for (const double v : y) {
        mean += v / static_cast<double>(y.size());
      }
      for (std::size_t k = 0; k < y.size(); ++k) {
        error += (y[k] - p[k]) * (y[k] - p[k]);
        spread += (y[k] - mean) * (y[k] - mean);
      }
    }
    return spread > 0.0 ? 100.0 * (1.0 - std::sqrt(error / spread)) : 0.0;
  }

  const FlightLog& log;
  TranslationData data;
  TranslationBlocks blocks;
  std::vector<double> measured;
};

bool both_have(const Request& request, Signal signal) {
  return request.log->has(signal) && (request.validation_log == nullptr || request.validation_log->has(signal));
}

/// Where thrust comes from in this log: a set point, else what the training part itself prefers.
Thrust thrust_source(const Request& request) {
  if (both_have(request, Signal::kThrustRatio)) {
    return Thrust::kSetPoint;
  }
  std::vector<Thrust> rivals{Thrust::kWeight};
  if (request.log->has(Signal::kAttitudeRoll) && request.log->has(Signal::kAttitudePitch)) {
    rivals.push_back(Thrust::kTangents);
  }
  Thrust present = Thrust::kVertical;
  for (const Thrust rival : rivals) {
    const TranslationData before(*request.log, present);
    const TranslationData after(*request.log, rival);
    const double preference = TranslationFamily::preference(TranslationBlocks(before, request.train),
                                                            TranslationBlocks(after, request.train));
    present = preference > 0.5 ? rival : present;
  }
  return present;
}

class TranslationIdentification {
 public:
  explicit TranslationIdentification(const Request& request)
      : request_(request),
        thrust_(thrust_source(request)),
        training_(*request.log, request.train, thrust_),
        validation_(request.validation_log != nullptr ? *request.validation_log : *request.log, request.validate,
                    thrust_),
        family_(training_.blocks) {
    check();
  }

  IdentifyResult run() {
    const auto started = std::chrono::steady_clock::now();
    IdentifyResult result;
    result.axis = request_.axis;
    SelectionOptions options;
    options.minimum_cv_gain = kMinimumCvGain;
    options.progress = request_.progress;
    const Selection selection = select(family_, request_.declared, options);
    result.candidates = selection.table;
    result.not_separable = selection.not_separable;
    result.findings = selection.notes;
    Fit final_fit = selection.final_model.fit;
    std::vector<Step> steps = selection.steps;
    withdraw_what_does_not_hold(steps, final_fit, result);
    result.unexplained = leftovers(final_fit);
    if (!result.unexplained.empty() && !steps.empty() &&
        (weak(final_fit, selection.declared.fit) || swinging(steps, result))) {
      for (const Step& step : steps) {
        result.findings.push_back("the residual goes along with " + step.name +
                                  ", but what is left has a cause of its own: the name would be a guess");
      }
      steps.clear();
      result.not_separable.clear();
      final_fit = selection.declared.fit;
      result.unexplained = leftovers(final_fit);
    }
    result.declared = model_result(selection.declared.fit);
    result.final_model = model_result(final_fit);
    intervals(final_fit, result);
    effects(final_fit, steps, result);
    aliases(steps, result);
    findings(result);
    figures(selection.declared.fit, final_fit, result);
    result.noise_floor = request_.noise_floor;
    result.verdict = !result.unexplained.empty() ? "unexplained"
                     : result.effects.empty()    ? "nothing_missing"
                                                 : "explained";
    result.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return result;
  }

 private:
  void check() const {
    const std::vector<std::string>& declared = request_.declared;
    if (declared.empty() || declared[0] != "rigid_body") {
      throw InputError("--declare", 0, declared.empty() ? "" : declared[0], "the first name must be rigid_body");
    }
    for (std::size_t k = 1; k < declared.size(); ++k) {
      if (!TranslationFamily::knows(declared[k]) || declared[k] == "rigid_body") {
        throw InputError("--declare", 0, declared[k], "not an effect of translation");
      }
      if (!family_.can_see(declared[k])) {
        throw InputError(request_.log->file, 0, declared[k], "the log has no signal that this effect would show in");
      }
    }
    if (training_.blocks.blocks.size() < kLeastBlocks) {
      throw InputError(request_.log->file, 0, "--train",
                       "needs at least " + std::to_string(kLeastBlocks) + " blocks of 2.5 s with data, has " +
                           std::to_string(training_.blocks.blocks.size()));
    }
    if (validation_.blocks.blocks.empty()) {
      throw InputError(validation_.log.file, 0, "--validate", "needs at least one block of 2.5 s with data");
    }
    double spread = 0.0;
    for (std::size_t k = 1; k < training_.measured.size(); ++k) {
      spread = std::max(spread, std::abs(training_.measured[k] - training_.measured[0]));
    }
    if (!(spread > 0.0)) {
      throw InputError(request_.log->file, 0, training_.data.source, "is one constant in the training ranges");
    }
  }

  ModelResult model_result(const Fit& fit) const {
    ModelResult out;
    out.structure = fit.structure;
    for (const std::string& name : fit.structure) {
      for (const NamedValue& value : TranslationFamily::parameters(fit, name)) {
        out.parameters.push_back(value);
      }
    }
    out.train_rmse = training_.rmse(TranslationFamily::prediction(training_.blocks, fit));
    const std::vector<double> predicted = TranslationFamily::prediction(validation_.blocks, fit);
    out.validation_rmse = validation_.rmse(predicted);
    out.fit_percent = validation_.fit_percent(predicted);
    out.horizon_rmse = horizons(predicted);
    return out;
  }

  /// How wrong the mean acceleration over a horizon is: the error of the predicted velocity change over its time.
  std::vector<std::pair<double, double>> horizons(const std::vector<double>& predicted) const {
    std::vector<std::pair<double, double>> out;
    for (const double horizon_s : kHorizons_s) {
      const auto length = static_cast<std::size_t>(std::lround(horizon_s / validation_.blocks.sample_period_s));
      double sum = 0.0;
      std::size_t count = 0;
      for (const auto& block : validation_.blocks.blocks) {
        for (std::size_t c = 0; c < validation_.data.axes; ++c) {
          const std::size_t row = block.row + c * block.samples.size();
          for (std::size_t k = 0; k + length <= block.samples.size(); k += 3) {
            double error = 0.0;
            for (std::size_t j = row + k; j < row + k + length; ++j) {
              error += (validation_.measured[j] - predicted[j]) / static_cast<double>(length);
            }
            sum += error * error;
            ++count;
          }
        }
      }
      out.emplace_back(horizon_s, count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0);
    }
    return out;
  }

  /// An effect that makes unseen data worse is none, however well it fitted.
  void withdraw_what_does_not_hold(std::vector<Step>& steps, Fit& fit, IdentifyResult& result) const {
    for (std::size_t at = steps.size(); at-- > 0;) {
      const std::vector<int> all(family_.block_count(), 1);
      const std::string name = steps[at].name;
      const Fit plain = family_.fit(family_.without(fit.structure, name), all, nullptr);
      if (validation_.rmse(TranslationFamily::prediction(validation_.blocks, fit)) <
          most_in_validation(steps[at]) * validation_.rmse(TranslationFamily::prediction(validation_.blocks, plain))) {
        continue;
      }
      result.findings.push_back(name + " fits the training part but makes the validation part no better: withdrawn");
      std::erase_if(result.not_separable,
                    [&](const auto& group) { return std::find(group.begin(), group.end(), name) != group.end(); });
      steps.erase(steps.begin() + static_cast<std::ptrdiff_t>(at));
      fit = plain;
    }
  }

  /// Little of the error is explained: with a remainder of unknown cause, so small a share may be the cause's shadow.
  bool weak(const Fit& fit, const Fit& declared) const {
    return fit.sum_of_squares > (1.0 - kWeakShare) * declared.sum_of_squares;
  }

  /// A line was named, and yet what is left still swings: it was never a line.
  static bool swinging(const std::vector<Step>& steps, const IdentifyResult& result) {
    const auto starts = [](const std::string& text, const char* with) { return text.rfind(with, 0) == 0; };
    return std::any_of(steps.begin(), steps.end(), [](const Step& step) { return step.name == "periodic_wind"; }) &&
           std::any_of(result.unexplained.begin(), result.unexplained.end(), [&](const std::string& text) {
             return starts(text, "periodic") || starts(text, "oscillation");
           });
  }

  void intervals(const Fit& fit, IdentifyResult& result) const {
    const std::size_t blocks = family_.block_count();
    std::mt19937_64 random(request_.seed);
    std::vector<std::vector<double>> samples;
    for (std::size_t draw = 0; draw < request_.bootstrap_draws; ++draw) {
      std::vector<int> weights(blocks, 0);
      for (std::size_t k = 0; k < blocks; ++k) {
        ++weights[static_cast<std::size_t>(random() % blocks)];
      }
      const Fit drawn = family_.fit(fit.structure, weights, &fit);
      std::size_t at = 0;
      for (const std::string& name : fit.structure) {
        for (const NamedValue& value : TranslationFamily::parameters(drawn, name)) {
          samples.resize(std::max(samples.size(), at + 1));
          samples[at++].push_back(value.value);
        }
      }
    }
    const double n = static_cast<double>(blocks);
    const double widening = n > 1.0 ? std::sqrt(n / (n - 1.0)) : 1.0;
    for (std::size_t k = 0; k < result.final_model.parameters.size(); ++k) {
      const NamedValue& parameter = result.final_model.parameters[k];
      Interval interval{parameter.value, parameter.value, parameter.value};
      if (k < samples.size() && !samples[k].empty()) {
        std::sort(samples[k].begin(), samples[k].end());
        const auto quantile = [&](double q) {
          return samples[k][static_cast<std::size_t>(std::lround(q * static_cast<double>(samples[k].size() - 1)))];
        };
        interval.low = std::min(parameter.value, parameter.value + widening * (quantile(0.025) - parameter.value));
        interval.high = std::max(parameter.value, parameter.value + widening * (quantile(0.975) - parameter.value));
      }
      result.final_intervals.push_back({parameter.name, interval});
    }
  }

  void effects(const Fit& final_fit, const std::vector<Step>& steps, IdentifyResult& result) const {
    for (std::size_t at = 0; at < steps.size(); ++at) {
      EffectResult effect;
      effect.name = steps[at].name;
      effect.cv_gain = steps[at].cv_gain;
      effect.delta_bic = steps[at].delta_bic;
      effect.paired_t = steps[at].paired_t;
      std::size_t parameter = 0;
      for (const std::string& name : final_fit.structure) {
        const std::size_t count = TranslationFamily::parameters(final_fit, name).size();
        for (std::size_t k = 0; k < count && name == effect.name; ++k) {
          effect.parameters.push_back(result.final_intervals[parameter + k]);
        }
        parameter += count;
      }
      Structure nested = final_fit.structure;
      for (std::size_t later = at + 1; later < steps.size(); ++later) {
        nested = family_.without(nested, steps[later].name);
      }
      const std::vector<int> all(family_.block_count(), 1);
      const Fit fit = nested == final_fit.structure ? final_fit : family_.fit(nested, all, nullptr);
      effect.validation_rmse_after = validation_.rmse(TranslationFamily::prediction(validation_.blocks, fit));
      for (const Step::Runner& rival : steps[at].rivals) {
        effect.rivals.push_back({rival.name,
                                 validation_.rmse(TranslationFamily::prediction(validation_.blocks, rival.fit)),
                                 rival.cv_ratio});
      }
      result.effects.push_back(std::move(effect));
    }
  }

  /// At constant heading a wind, a bias of the body and a trim of the sticks are one and the same: said by name.
  void aliases(const std::vector<Step>& steps, IdentifyResult& result) const {
    for (const Step& step : steps) {
      const bool constant = step.name == "steady_wind" || step.name == "body_bias";
      const std::string other = step.name == "steady_wind" ? "body_bias" : "steady_wind";
      const auto named = [&](const std::vector<std::string>& group) {
        return std::find(group.begin(), group.end(), step.name) != group.end() &&
               std::find(group.begin(), group.end(), other) != group.end();
      };
      if (!constant) {
        continue;
      }
      if (!training_.data.has_yaw && std::none_of(result.not_separable.begin(), result.not_separable.end(), named)) {
        result.not_separable.push_back({step.name, other});
        result.findings.emplace_back("without attitude_yaw a wind cannot be told from what turns with the body");
      }
      if (std::any_of(result.not_separable.begin(), result.not_separable.end(), named)) {
        result.not_separable.push_back({step.name, "trim_offset"});
        result.findings.emplace_back("the heading hardly changed: turn the vehicle in flight to tell wind from bias");
      }
    }
    const auto has = [&](const char* name) {
      return std::any_of(steps.begin(), steps.end(), [&](const Step& step) { return step.name == name; });
    };
    if (has("steady_wind") && (has("linear_drag") || has("quadratic_drag"))) {
      result.findings.emplace_back(
          "wind and drag are one model: drag acts on the velocity relative to the air; the wind's acceleration is "
          "known, its speed only as well as the drag coefficient");
    }
  }

  /// Prediction error of both parts, axis by axis, tested for what may still predict it.
  std::vector<std::string> leftovers(const Fit& fit) const {
    ResidualInput input;
    input.sample_period_s = training_.blocks.sample_period_s;
    input.noise_floor = request_.noise_floor;
    input.residuals.resize(training_.data.axes);
    append(training_, fit, input);
    append(validation_, fit, input);
    ResidualOptions options;
    options.minimum_share = kMinimumShare;
    // What the residual itself moves is tested apart, and has to show more.
    ResidualInput moved = input;
    moved.activity.clear();
    moved.groups.clear();
    for (std::size_t g = input.groups.size(); g-- > 0;) {
      if (input.groups[g].source.rfind("velocity", 0) == 0) {
        moved.groups.push_back(std::move(input.groups[g]));
        input.groups.erase(input.groups.begin() + static_cast<std::ptrdiff_t>(g));
      }
    }
    ResidualFinding finding = test_residual(input, options);
    options.minimum_share = kMinimumMovedShare;
    const ResidualFinding second = moved.groups.empty() ? ResidualFinding{} : test_residual(moved, options);
    for (const std::string& said : second.unexplained) {
      if (said.rfind("predictable", 0) == 0) {
        finding.unexplained.push_back(said);
      }
    }
    if (finding.unexplained.empty()) {
      for (std::size_t c = 0; c < 2; ++c) {
        const std::string swing = swings(input.residuals[c], input.sample_period_s);
        if (!swing.empty()) {
          finding.unexplained.push_back(swing);
          break;
        }
      }
    }
    return finding.unexplained;
  }

  /// Air has no memory that changes sign; something that swings has.
  static std::string swings(const std::vector<double>& residual, double period_s) {
    const auto longest = std::min(residual.size() / 4, static_cast<std::size_t>(std::lround(3.0 / period_s)));
    double lowest = 0.0;
    std::size_t at = 0;
    for (auto lag = static_cast<std::size_t>(kSwingFrom_s / period_s); lag < longest; ++lag) {
      const double correlation = autocorrelation(residual, lag);
      if (correlation < lowest) {
        lowest = correlation;
        at = lag;
      }
    }
    return lowest < kSwing ? sentence("oscillation near %.2f Hz (autocorrelation %.2f half a period later)",
                                      0.5 / (static_cast<double>(at) * period_s), lowest)
                           : "";
  }

  static double autocorrelation(const std::vector<double>& values, std::size_t lag) {
    double mean = 0.0;
    for (const double value : values) {
      mean += value / static_cast<double>(values.size());
    }
    double product = 0.0;
    double power = 0.0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      power += (values[k] - mean) * (values[k] - mean);
      product += k >= lag ? (values[k] - mean) * (values[k - lag] - mean) : 0.0;
    }
    return power > 0.0 ? product / power : 0.0;
  }

  void append(const Part& part, const Fit& fit, ResidualInput& input) const {
    const std::vector<double> predicted = TranslationFamily::prediction(part.blocks, fit);
    std::vector<double> error(predicted.size());
    std::transform(part.measured.begin(), part.measured.end(), predicted.begin(), error.begin(), std::minus<>{});
    for (const auto& block : part.blocks.blocks) {
      input.block_begin.push_back(input.time_s.size());
      for (const std::size_t i : block.samples) {
        input.time_s.push_back(part.data.time_s(i));
      }
    }
    for (std::size_t c = 0; c < part.data.axes; ++c) {
      const std::vector<double> axis = part.axis(error, c);
      input.residuals[c].insert(input.residuals[c].end(), axis.begin(), axis.end());
    }
    merge(input.groups, causes(part));
    merge(input.activity, activity(part));
  }

  static void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more) {
    if (into.empty()) {
      into = std::move(more);
      return;
    }
    for (std::size_t g = 0; g < std::min(into.size(), more.size()); ++g) {
      for (std::size_t k = 0; k < into[g].columns.size(); ++k) {
        into[g].columns[k].insert(into[g].columns[k].end(), more[g].columns[k].begin(), more[g].columns[k].end());
      }
    }
  }

  /// Columns of one channel at the blocks' samples, each lag seconds earlier.
  static std::vector<std::vector<double>> earlier(const Part& part, const std::vector<double>& channel,
                                                  const std::vector<double>& lags_s) {
    std::vector<std::vector<double>> out;
    for (const double lag_s : lags_s) {
      const auto lag = static_cast<std::size_t>(std::lround(lag_s / part.data.period_s));
      out.emplace_back();
      for (const auto& block : part.blocks.blocks) {
        for (const std::size_t i : block.samples) {
          out.back().push_back(channel[i > lag ? i - lag : 0]);
        }
      }
    }
    return out;
  }

  static RegressorGroup group(const Part& part, const std::string& name,
                              const std::vector<const std::vector<double>*>& channels,
                              const std::vector<double>& lags_s) {
    RegressorGroup out{name, {}};
    for (const std::vector<double>* channel : channels) {
      for (std::vector<double>& column : earlier(part, *channel, lags_s)) {
        out.columns.push_back(std::move(column));
      }
    }
    return out;
  }

  static RegressorGroup products(const Part& part, const std::string& name,
                                 const std::vector<const std::vector<double>*>& a,
                                 const std::vector<const std::vector<double>*>& b) {
    RegressorGroup out{name, {}};
    for (const std::vector<double>* one : a) {
      for (const std::vector<double>* other : b) {
        std::vector<double> both(one->size());
        std::transform(one->begin(), one->end(), other->begin(), both.begin(), std::multiplies<>{});
        out.columns.push_back(earlier(part, both, {0.0}).front());
      }
    }
    return out;
  }

  /// Only causes: tilt, thrust, sticks and heading with their past; velocity as it is, because its past contains the
  /// residual's own integral.
  std::vector<RegressorGroup> causes(const Part& part) const {
    const TranslationData& data = part.data;
    const std::vector<double> memory_s{0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.4, 1.8, 2.4};
    const std::size_t n = data.valid.size();
    std::vector<RegressorGroup> out;
    out.push_back(group(part, "tilt", {&data.direction[0], &data.direction[1]}, memory_s));
    out.push_back(products(part, "tilt * tilt", {&data.direction[0], &data.direction[1]},
                           {&data.direction[0], &data.direction[1]}));
    if (data.has_thrust) {
      out.push_back(group(part, "thrust", {&data.thrust}, {0.0, 0.1, 0.25, 0.5}));
    }
    if (data.has_velocity) {
      std::vector<double> squared_x(n);
      std::vector<double> squared_y(n);
      for (std::size_t i = 0; i < n; ++i) {
        const double speed = std::hypot(data.velocity[0][i], data.velocity[1][i]);
        squared_x[i] = speed * data.velocity[0][i];
        squared_y[i] = speed * data.velocity[1][i];
      }
      out.push_back(products(part, "tilt * velocity", {&data.direction[0], &data.direction[1]},
                             {&data.velocity[0], &data.velocity[1], &data.velocity[2]}));
      out.push_back(group(part, "velocity", {&data.velocity[0], &data.velocity[1], &data.velocity[2]}, {0.0}));
      out.push_back(group(part, "velocity squared", {&squared_x, &squared_y}, {0.0}));
    }
    std::vector<double> cosine(n);
    std::vector<double> sine(n);
    std::vector<double> time(n);
    for (std::size_t i = 0; i < n; ++i) {
      cosine[i] = std::cos(data.yaw_rad[i]);
      sine[i] = std::sin(data.yaw_rad[i]);
      time[i] = data.time_s(i);
    }
    if (data.has_yaw) {
      out.push_back(group(part, "heading", {&cosine, &sine}, {0.0}));
    }
    out.push_back(group(part, "time", {&time}, {0.0}));
    for (const Signal stick : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
      if (both_have(request_, stick)) {
        std::vector<double> on_x = part.log.of(stick);
        std::vector<double> on_y = on_x;
        for (std::size_t i = 0; i < n; ++i) {
          on_x[i] *= cosine[i];
          on_y[i] *= sine[i];
        }
        out.push_back(group(part, std::string(name_of(stick)), {&on_x, &on_y}, {0.0, 0.2, 0.5, 1.0}));
      }
    }
    for (const auto& [name, values] : part.log.extra) {
      if (request_.validation_log == nullptr || request_.validation_log->extra.count(name) > 0) {
        out.push_back(group(part, name, {&values}, {0.0, 0.2, 0.5, 1.0}));
      }
    }
    return out;
  }

  static std::vector<RegressorGroup> activity(const Part& part) {
    const TranslationData& data = part.data;
    std::vector<double> tilt(data.valid.size());
    std::vector<double> speed(data.valid.size());
    for (std::size_t i = 0; i < tilt.size(); ++i) {
      tilt[i] = std::hypot(data.direction[0][i], data.direction[1][i]);
      speed[i] = std::hypot(data.velocity[0][i], data.velocity[1][i]);
    }
    std::vector<RegressorGroup> out{group(part, "size of tilt", {&tilt}, {0.0, 0.2, 0.5})};
    if (data.has_velocity) {
      out.push_back(group(part, "speed", {&speed}, {0.0}));
    }
    return out;
  }

  void findings(IdentifyResult& result) const {
    const logs::Alignment& found = request_.log->alignment;
    result.alignment = {static_cast<double>(found.stick_shift_samples), found.evidence};
    const std::vector<std::string> ground = ground_findings(ground_times(*request_.log));
    result.findings.insert(result.findings.end(), ground.begin(), ground.end());
    result.findings.insert(result.findings.end(), request_.log->notes.begin(), request_.log->notes.end());
    result.findings.push_back("acceleration from " + training_.data.source +
                              ", filtered over 0.2 s like the prediction");
    if (!training_.data.has_thrust) {
      result.findings.emplace_back(std::string("no thrust set point in the log: thrust is taken as ") +
                                   (thrust_ == Thrust::kVertical ? "what the vertical shows"
                                    : thrust_ == Thrust::kWeight ? "weight over the cosine of the tilt"
                                                                 : "g times the tangents of roll and pitch") +
                                   ", which these data prefer; only the horizontal axes are tested");
    }
    for (const CandidateRow& row : result.candidates) {
      const bool refused = row.name == "periodic_wind" && !row.accepted && !row.big_enough && row.cv_gain > 0.25;
      if (refused && row.round == result.candidates.back().round) {
        result.findings.emplace_back(
            "a periodic force would fit, but the vehicle itself moves with that period: not claimed");
      }
    }
  }

  void figures(const Fit& declared, const Fit& final_fit, IdentifyResult& result) const {
    Figures& out = result.figures;
    static const std::array<const char*, 3> kAxes{"_x", "_y", "_z"};
    for (const Part* part : {&training_, &validation_}) {
      for (const auto& block : part->blocks.blocks) {
        for (const std::size_t i : block.samples) {
          out.t_s.push_back(part->data.time_s(i));
          out.validation.push_back(part == &validation_ ? 1 : 0);
        }
      }
    }
    std::vector<double> all_declared;
    std::vector<double> all_final;
    for (std::size_t c = 0; c < training_.data.axes; ++c) {
      const auto series = [&](const char* name) {
        out.series.push_back({std::string(name) + kAxes[c], {}});
        return out.series.size() - 1;
      };
      const std::size_t first = series("measured");
      series("declared"), series("final"), series("declared_residual"), series("final_residual");
      for (const Part* part : {&training_, &validation_}) {
        const std::vector<double> y = part->axis(part->measured, c);
        const std::vector<double> d = part->axis(TranslationFamily::prediction(part->blocks, declared), c);
        const std::vector<double> f = part->axis(TranslationFamily::prediction(part->blocks, final_fit), c);
        for (std::size_t k = 0; k < y.size(); ++k) {
          out.series[first].values.push_back(y[k]);
          out.series[first + 1].values.push_back(d[k]);
          out.series[first + 2].values.push_back(f[k]);
          out.series[first + 3].values.push_back(y[k] - d[k]);
          out.series[first + 4].values.push_back(y[k] - f[k]);
          all_declared.push_back(y[k] - d[k]);
          all_final.push_back(y[k] - f[k]);
        }
      }
    }
    const auto lags = static_cast<std::size_t>(std::lround(3.0 / training_.blocks.sample_period_s));
    for (std::size_t lag = 0; lag <= lags && lag < all_final.size(); ++lag) {
      out.lag_s.push_back(static_cast<double>(lag) * training_.blocks.sample_period_s);
      out.declared_autocorrelation.push_back(autocorrelation(all_declared, lag));
      out.final_autocorrelation.push_back(autocorrelation(all_final, lag));
    }
  }

  const Request& request_;
  Thrust thrust_;
  Part training_;
  Part validation_;
  TranslationFamily family_;
};

}  // namespace

IdentifyResult identify_translation(const Request& request) { return TranslationIdentification(request).run(); }

}  // namespace m100::tools::identify
