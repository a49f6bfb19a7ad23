// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_scale.h"
#include "host_tests/lab/statistics.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {
namespace {

/// Fits the straight line of the response against the stick, at the lag at which it explains most of the response.
void fit_line(const AxisBlocks& training, AxisScale& scale) {
  const AxisData& data = training.data();
  double best = -1.0;
  for (std::size_t lag = 0; lag <= 60; lag += 5) {
    double n = 0.0, u = 0.0, y = 0.0, uu = 0.0, uy = 0.0;
    for (std::size_t number = 0; number < training.size(); ++number) {
      for (std::size_t i = std::max(training[number].begin, lag); i < training[number].end; ++i) {
        const double stick = data.stick[i - lag] - data.stick[training[0].begin];  // no digits lost to a far neutral
        n += 1.0;
        u += stick;
        y += data.measured[i];
        uu += stick * stick;
        uy += stick * data.measured[i];
      }
    }
    const double variance = uu - u * u / std::max(1.0, n);
    const double common = uy - u * y / std::max(1.0, n);
    if (variance > 0.0 && common * common / variance > best) {
      best = common * common / variance;
      scale.gain = common / variance;
      const double offset = std::abs(scale.gain) > 0.0 ? y / scale.gain : 0.0;
      scale.centre = data.stick[training[0].begin] + (u - offset) / n;
    }
  }
}

}  // namespace

AxisScale scale_of(const AxisBlocks& training) {
  const AxisData& data = training.data();
  std::vector<double> sticks;
  std::vector<double> responses;
  std::vector<double> rates;
  AxisScale scale;
  fit_line(training, scale);
  for (std::size_t number = 0; number < training.size(); ++number) {
    for (std::size_t i = training[number].begin; i < training[number].end; ++i) {
      sticks.push_back(data.stick[i]);
      responses.push_back(std::abs(data.measured[i]));
      if (i >= training[number].begin + 6) {
        rates.push_back(std::abs(data.measured[i] - data.measured[i - 6]) / (6.0 * data.period_s));
      }
    }
  }
  scale.centre = std::clamp(scale.centre, quantile(sticks, 0.02), quantile(sticks, 0.98));
  std::transform(sticks.begin(), sticks.end(), sticks.begin(),
                 [&](double stick) { return std::abs(stick - scale.centre); });
  scale.stick = std::max(quantile(sticks, 0.98), 1e-9);
  scale.response = std::max(quantile(responses, 0.98), 1e-9);
  scale.rate_per_s = std::max(quantile(rates, 0.99), 1e-9);
  scale.minimum_counts = scale.stick > 5.0 ? 1.0 : 1.0 / 660.0;
  if (std::abs(scale.gain) < 1e-9 * scale.response / scale.stick) {
    scale.gain = scale.response / scale.stick;
  }
  return scale;
}

double AxisScale::of(model::AxisNumber::FitUnit unit) const {
  using Unit = model::AxisNumber::FitUnit;
  switch (unit) {
    case Unit::kStick:
      return stick;
    case Unit::kCommand:
      return response;
    case Unit::kRate:
      return rate_per_s;
    case Unit::kGain:
      return gain;
    case Unit::kPlain:
      break;
  }
  return 1.0;
}

double AxisScale::physical(const model::AxisNumber& number, double in_unit) const {
  return origin(number) + in_unit * of(number.unit);
}

double AxisScale::in_unit(const model::AxisNumber& number, double physical) const {
  return (physical - origin(number)) / of(number.unit);
}

double AxisScale::origin(const model::AxisNumber& number) const {
  return number.member == &model::StickAxis::trim_counts ? centre : 0.0;
}

}  // namespace m100::lab::identify
