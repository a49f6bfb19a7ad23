// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_scale.h"
#include "host_tests/lab/statistics.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {
namespace {

/// Ratio of response to stick, by least squares at the lag that explains most of the response.
double gain_of(const AxisBlocks& training) {
  const AxisData& data = training.data();
  double gain = AxisScale{}.gain;
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
      gain = uy / uu;
    }
  }
  return gain;
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
  scale.gain = gain_of(training);
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

}  // namespace m100::lab::identify
