// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/translation/translation_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "host_tests/lab/identify/model/translation/translation_family.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify::translation {
namespace {

using logs::Signal;

constexpr double kMinimumShare = 0.14;  // higher than on a stick axis: more axes and channels give chance more trials
/// Velocity is a cause only if it predicts more than this share, because a gust moves both velocity and residual.
constexpr double kMinimumMovedShare = 0.25;
constexpr double kOscillation =
    -0.45;  // an autocorrelation below this is an oscillation, which air alone does not cause
constexpr double kOscillationFrom_s = 0.3;

/// Detects an oscillation by its negative autocorrelation, which air alone does not have.
std::string describe_oscillation(const std::vector<double>& residual, double period_s) {
  const auto longest = std::min(residual.size() / 4, static_cast<std::size_t>(std::lround(3.0 / period_s)));
  double lowest = 0.0;
  std::size_t at = 0;
  for (auto lag = static_cast<std::size_t>(kOscillationFrom_s / period_s); lag < longest; ++lag) {
    const double correlation = autocorrelation(residual, lag, true);
    if (correlation < lowest) {
      lowest = correlation;
      at = lag;
    }
  }
  if (!(lowest < kOscillation)) {
    return "";
  }
  return printed("oscillation near %.2f Hz (autocorrelation %.2f half a period later)",
                 0.5 / (static_cast<double>(at) * period_s), lowest);
}

/// One column for each lag: the channel that much earlier than the blocks' samples.
std::vector<std::vector<double>> earlier(const TranslationDataSet& part, const std::vector<double>& channel,
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

RegressorGroup group(const TranslationDataSet& part, const std::string& name,
                     const std::vector<const std::vector<double>*>& channels, const std::vector<double>& lags_s) {
  RegressorGroup out{name, {}};
  for (const std::vector<double>* channel : channels) {
    for (std::vector<double>& column : earlier(part, *channel, lags_s)) {
      out.columns.push_back(std::move(column));
    }
  }
  return out;
}

RegressorGroup products(const TranslationDataSet& part, const std::string& name,
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

/// The horizontal velocity times its size.
std::array<std::vector<double>, 2> times_speed(const TranslationData& data) {
  std::array<std::vector<double>, 2> out{data.velocity[0], data.velocity[1]};
  for (std::size_t i = 0; i < out[0].size(); ++i) {
    const double speed = std::hypot(out[0][i], out[1][i]);
    out[0][i] *= speed;
    out[1][i] *= speed;
  }
  return out;
}

/// Regressors that are possible causes: tilt, thrust set point, sticks and extra channels with their past; heading,
/// time and velocity without their past. The past of velocity would contain the integral of the residual.
std::vector<RegressorGroup> causes(const Request& request, const TranslationDataSet& part) {
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
    const auto [squared_x, squared_y] = times_speed(data);
    out.push_back(products(part, "tilt * velocity", {&data.direction[0], &data.direction[1]},
                           {&data.velocity[0], &data.velocity[1], &data.velocity[2]}));
    out.push_back(group(part, "velocity", {&data.velocity[0], &data.velocity[1], &data.velocity[2]}, {0.0}));
    out.push_back(group(part, "velocity squared", {&squared_x, &squared_y}, {0.0}));
  }
  const std::vector<double>& cosine = data.heading_cosine;
  const std::vector<double>& sine = data.heading_sine;
  std::vector<double> time(n);
  for (std::size_t i = 0; i < n; ++i) {
    time[i] = data.time_s(i);
  }
  if (data.has_yaw) {
    out.push_back(group(part, "heading", {&cosine, &sine}, {0.0}));
  }
  out.push_back(group(part, "time", {&time}, {0.0}));
  for (const Signal stick : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    if (both_have(request, stick)) {
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
    if (request.validation_log == nullptr || request.validation_log->extra.count(name) > 0) {
      out.push_back(group(part, name, {&values}, {0.0, 0.2, 0.5, 1.0}));
    }
  }
  return out;
}

std::vector<RegressorGroup> activity(const TranslationDataSet& part) {
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

/// @param first_flight  number of the log's first flight, so that two logs share no number
void append(const Request& request, const TranslationDataSet& part, const Fit& fit, std::size_t first_flight,
            ResidualInput& input) {
  const std::vector<double> predicted = TranslationFamily::prediction(part.blocks, fit);
  std::vector<double> error(predicted.size());
  std::transform(part.measured.begin(), part.measured.end(), predicted.begin(), error.begin(), std::minus<>{});
  for (const auto& block : part.blocks.blocks) {
    input.block_begin.push_back(input.time_s.size());
    for (const std::size_t i : block.samples) {
      input.time_s.push_back(part.data.time_s(i));
      const auto begun = std::count_if(part.log.flights.begin(), part.log.flights.end(),
                                       [&](const logs::Flight& flight) { return flight.begin <= i; });
      input.flight.push_back(first_flight + static_cast<std::size_t>(begun));
    }
  }
  for (std::size_t c = 0; c < part.data.axes; ++c) {
    const std::vector<double> axis = part.axis(error, c);
    input.residuals[c].insert(input.residuals[c].end(), axis.begin(), axis.end());
  }
  merge(input.groups, causes(request, part));
  merge(input.activity, activity(part));
}

}  // namespace

std::vector<std::string> residual_findings(const Request& request, const TranslationDataSet& training,
                                           const TranslationDataSet& validation, const Fit& fit) {
  ResidualInput input;
  input.sample_period_s = training.blocks.sample_period_s;
  input.noise_floor = request.noise_floor;
  input.residuals.resize(training.data.axes);
  append(request, training, fit, 0, input);
  const bool one_log = &validation.log == &training.log;
  append(request, validation, fit, one_log ? 0 : training.log.flights.size() + 1, input);
  ResidualOptions options;
  options.minimum_share = kMinimumShare;
  // Velocity, which the residual itself moves, is tested separately with a higher threshold.
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
      const std::string swing = describe_oscillation(input.residuals[c], input.sample_period_s);
      if (!swing.empty()) {
        finding.unexplained.push_back(swing);
        break;
      }
    }
  }
  return finding.unexplained;
}

}  // namespace m100::lab::identify::translation
