// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/paper/paper.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/model/levenberg_marquardt.h"

namespace m100::lab::identify::paper {
namespace {

double mean_period(const std::vector<double>& t_s) {
  return (t_s.back() - t_s.front()) / static_cast<double>(t_s.size() - 1);
}

/// First row whose time plus `moved_s` lies within one period of `at_s`; row 0 if there is none.
std::size_t row_near(const std::vector<double>& clock_s, double at_s, double moved_s, double period_s) {
  for (std::size_t row = 0; row < clock_s.size(); ++row) {
    if (std::abs(clock_s[row] + moved_s - at_s) < period_s) {
      return row;
    }
  }
  return 0;
}

std::vector<double> without_line(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double at = static_cast<double>(i);
    x += at, y += values[i], xx += at * at, xy += at * values[i];
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  const double offset = (y - slope * x) / n;
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    out[i] = values[i] - offset - slope * static_cast<double>(i);
  }
  return out;
}

void take_mean_off(std::vector<double>& values) {
  double mean = 0.0;
  for (const double value : values) {
    mean += value / static_cast<double>(values.size());
  }
  for (double& value : values) {
    value -= mean;
  }
}

struct Cut {
  std::vector<double> input, output;
  double period_s;
};

Cut cut(const Record& record, double scale, double from_s, double to_s) {
  Cut out{{}, {}, mean_period(record.t_s)};
  for (std::size_t row = 0; row < record.t_s.size(); ++row) {
    if (record.t_s[row] > from_s && record.t_s[row] < to_s) {
      out.input.push_back(scale * record.stick[row]);
      out.output.push_back(record.response[row]);
    }
  }
  take_mean_off(out.input);
  take_mean_off(out.output);
  return out;
}

/// @param x  gain, logarithms of the dynamics' parameters, then the initial state, which the model does not have
model::StickAxis model_of(std::span<const double> x, bool second) {
  model::StickAxis axis;
  axis.scale_per_count = x[0];
  if (second) {
    axis.natural_frequency_rad_s = std::exp(x[1]);
    axis.damping_ratio = std::exp(x[2]);
  } else {
    axis.time_constant_s = std::exp(x[1]);
  }
  return axis;
}

/// Starting point and bounds of a fit. The free initial value begins at the first measured value.
std::pair<std::vector<double>, std::vector<Box>> start_of(double first_value, bool second) {
  std::vector<double> x{1.0, std::log(second ? 5.0 : 0.3)};
  std::vector<Box> box{{-10.0, 10.0, 1e-5}, {std::log(1e-2), std::log(50.0), 1e-5}};
  if (second) {
    x.push_back(std::log(0.7));
    box.push_back({std::log(0.02), std::log(5.0), 1e-5});
  }
  for (int start = 0; start < (second ? 2 : 1); ++start) {
    x.push_back(start == 0 ? first_value : 0.0);
    box.push_back({-50.0, 50.0, 1e-5});
  }
  return {x, box};
}

Dynamics fit(const Record& record, double scale, double from_s, double to_s, bool second) {
  const Cut data = cut(record, scale, from_s, to_s);
  const std::size_t rows = data.input.size();
  const auto residual = [&](std::span<const double> x, std::span<double> out) {
    const model::StickAxis axis = model_of(x, second);
    sysid::AxisDynamics<double> dynamics(axis, data.period_s);
    dynamics.start(x[second ? 3 : 2], second ? x[4] : 0.0);
    for (std::size_t row = 0; row < rows; ++row) {
      out[row] = dynamics.value() - data.output[row];
      dynamics.step(axis.scale_per_count * data.input[row]);
    }
  };
  auto [x, box] = start_of(data.output[0], second);
  std::vector<double> scratch((x.size() + 2) * rows);
  const double left = levenberg_marquardt(residual, std::span<double>(x), box, rows, scratch, {100, 1e-12});
  const double power = std::inner_product(data.output.begin(), data.output.end(), data.output.begin(), 0.0);
  const model::StickAxis axis = model_of(x, second);
  return {axis.scale_per_count, axis.time_constant_s, axis.natural_frequency_rad_s, axis.damping_ratio,
          100.0 * (1.0 - std::sqrt(left / power))};
}

}  // namespace

int correlation_lag(const std::vector<double>& stick, const std::vector<double>& response, double period_s) {
  const auto maximum = static_cast<std::ptrdiff_t>(3.0 / period_s);
  const auto size = static_cast<std::ptrdiff_t>(std::min(stick.size(), response.size()));
  double best = -1.0;
  std::ptrdiff_t lag = 0;
  for (std::ptrdiff_t shift = -maximum; shift <= maximum; ++shift) {
    double sum = 0.0;
    for (std::ptrdiff_t row = std::max<std::ptrdiff_t>(0, shift); row < std::min(size, size + shift); ++row) {
      sum += response[static_cast<std::size_t>(row)] * stick[static_cast<std::size_t>(row - shift)];
    }
    if (sum > best) {
      best = sum;
      lag = shift;
    }
  }
  return static_cast<int>(lag);
}

double scale_factor(const Record& record, int lag, double from_s, double to_s) {
  const double period_s = mean_period(record.t_s);
  const double moved_s = static_cast<double>(lag) * period_s;
  const std::size_t u_begin = row_near(record.t_s, from_s, moved_s, period_s);
  const std::size_t u_end = row_near(record.t_s, to_s, moved_s, period_s) + 1;
  const std::size_t y_begin = row_near(record.t_s, from_s, 0.0, period_s);
  const std::size_t y_end = row_near(record.t_s, to_s, 0.0, period_s) + 1;
  const std::size_t count = std::min(u_end - u_begin, y_end - y_begin);
  const auto part = [count](const std::vector<double>& values, std::size_t begin) {
    return without_line({values.begin() + static_cast<std::ptrdiff_t>(begin),
                         values.begin() + static_cast<std::ptrdiff_t>(begin + count)});
  };
  const std::vector<double> u = part(record.stick, u_begin);
  const std::vector<double> y = part(record.response, y_begin);
  double uy = 0.0;
  double uu = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    uy += u[i] * y[i];
    uu += u[i] * u[i];
  }
  return uy / uu;
}

Dynamics first_order(const Record& record, double scale, double from_s, double to_s) {
  return fit(record, scale, from_s, to_s, false);
}

Dynamics second_order(const Record& record, double scale, double from_s, double to_s) {
  return fit(record, scale, from_s, to_s, true);
}

}  // namespace m100::lab::identify::paper
