// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/translation_data.h"
#include "host_tests/lab/identify/data/ground_time.h"
#include "host_tests/lab/identify/data/log_defects.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

constexpr double kHalfWindow_s = 0.1;

/// Slope of the least-squares line through the samples i - half .. i + half.
std::vector<double> slopes(const std::vector<double>& values, std::size_t half, double period_s) {
  double moment = 0.0;
  for (std::size_t j = 1; j <= half; ++j) {
    moment += 2.0 * static_cast<double>(j * j);
  }
  std::vector<double> out(values.size(), 0.0);
  for (std::size_t i = half; i + half < values.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = 1; j <= half; ++j) {
      sum += static_cast<double>(j) * (values[i + j] - values[i - j]);
    }
    out[i] = sum / (moment * period_s);
  }
  return out;
}

/// Weights of a mean over 2 * half sample periods (a trapezoidal integral divided by its time); half = 0: no filter.
std::vector<double> mean_weights(std::size_t half) {
  std::vector<double> out(2 * half + 1, 1.0 / static_cast<double>(std::max<std::size_t>(1, 2 * half)));
  if (half > 0) {
    out.front() *= 0.5;
    out.back() *= 0.5;
  }
  return out;
}

std::vector<double> convolved(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      out[i + j] += a[i] * b[j];
    }
  }
  return out;
}

/// Weights that slopes() of the trapezoidal integral applies to an acceleration.
std::vector<double> slope_weights(std::size_t half) {
  std::vector<double> weights(2 * half + 1);
  for (std::size_t m = 0; m < weights.size(); ++m) {
    std::vector<double> integral(weights.size(), 0.0);
    for (std::size_t j = 0; j < integral.size(); ++j) {
      integral[j] = j > m ? 1.0 : (j == m ? 0.5 : 0.0);
    }
    weights[m] = slopes(integral, half, 1.0)[half];
  }
  return weights;
}

void body_axes(const FlightLog& log, TranslationData& data) {
  const auto& roll = log.of(Signal::kAttitudeRoll);
  const auto& pitch = log.of(Signal::kAttitudePitch);
  const auto& yaw = log.of(Signal::kAttitudeYaw);
  for (std::size_t i = 0; i < log.size; ++i) {
    const double psi = yaw.empty() ? 0.0 : yaw[i];
    const double forward = std::sin(pitch[i]) * std::cos(roll[i]);
    data.direction[0][i] = forward * std::cos(psi) + std::sin(roll[i]) * std::sin(psi);
    data.direction[1][i] = forward * std::sin(psi) - std::sin(roll[i]) * std::cos(psi);
    data.direction[2][i] = std::cos(pitch[i]) * std::cos(roll[i]);
  }
}

/// ThrustSource::kTangents: the thrust is g times the vector (tan(pitch), -tan(roll), 1), turned by the heading.
void take_tangents(const FlightLog& log, TranslationData& data) {
  const auto tangent = [](double angle) {
    constexpr double kSteepest_rad = 1.2;
    return std::tan(std::clamp(angle, -kSteepest_rad, kSteepest_rad));
  };
  for (std::size_t i = 0; i < log.size; ++i) {
    const double forward = tangent(log.of(Signal::kAttitudePitch)[i]);
    const double left = -tangent(log.of(Signal::kAttitudeRoll)[i]);
    data.direction[0][i] = forward * data.heading_cosine[i] - left * data.heading_sine[i];
    data.direction[1][i] = forward * data.heading_sine[i] + left * data.heading_cosine[i];
    data.direction[2][i] = 1.0;
    data.thrust[i] = kStandardGravity_m_s2;
  }
}

/// The specific force rotated into the world frame, minus gravity.
std::array<std::vector<double>, 3> force_in_world(const FlightLog& log, const TranslationData& data) {
  std::array<std::vector<double>, 3> out;
  out.fill(std::vector<double>(log.size));
  const auto& roll = log.of(Signal::kAttitudeRoll);
  const auto& pitch = log.of(Signal::kAttitudePitch);
  for (std::size_t i = 0; i < log.size; ++i) {
    const double fx = log.of(Signal::kForceX)[i];
    const double fy = log.of(Signal::kForceY)[i];
    const double fz = log.of(Signal::kForceZ)[i];
    const double side = std::cos(roll[i]) * fy - std::sin(roll[i]) * fz;
    const double up = std::sin(roll[i]) * fy + std::cos(roll[i]) * fz;
    const double forward = std::cos(pitch[i]) * fx + std::sin(pitch[i]) * up;
    out[0][i] = forward * data.heading_cosine[i] - side * data.heading_sine[i];
    out[1][i] = forward * data.heading_sine[i] + side * data.heading_cosine[i];
    out[2][i] = std::cos(pitch[i]) * up - std::sin(pitch[i]) * fx - kStandardGravity_m_s2;
  }
  return out;
}

bool has_force(const FlightLog& log) {
  return log.has3(Signal::kForceX) && log.has(Signal::kAttitudeRoll) && log.has(Signal::kAttitudePitch);
}

/// Takes the acceleration from the specific force, with the data's weights.
void take_force(const FlightLog& log, TranslationData& data) {
  const std::array<std::vector<double>, 3> force = force_in_world(log, data);
  for (std::size_t c = 0; c < 3; ++c) {
    data.measured[c].assign(log.size, 0.0);
    for (std::size_t i = data.margin; i + data.margin < log.size; ++i) {
      data.measured[c][i] = data.filtered(force[c], i);
    }
  }
}

/// Takes the acceleration, and the velocity if there is one, and sets the weights of their filter.
void take_motion(const FlightLog& log, TranslationData& data) {
  const auto half = static_cast<std::size_t>(std::max(2L, std::lround(kHalfWindow_s / data.period_s)));
  data.weights = slope_weights(half);
  data.margin = half;
  data.source = data.has_velocity ? "velocity" : (log.has3(Signal::kPositionX) ? "position" : "force");
  for (std::size_t c = 0; c < 3; ++c) {
    const int n = static_cast<int>(c);
    if (data.has_velocity) {
      data.velocity[c] = log.of(logs::offset(Signal::kVelocityX, n));
      data.measured[c] = slopes(data.velocity[c], half, data.period_s);
    } else if (log.has3(Signal::kPositionX)) {
      data.velocity[c] = slopes(log.of(logs::offset(Signal::kPositionX, n)), half, data.period_s);
      data.measured[c] = slopes(data.velocity[c], half, data.period_s);
    }
  }
  if (data.source == "position") {
    data.has_velocity = true;
    data.weights = convolved(data.weights, data.weights);
    data.margin = 2 * half;
  }
  const auto mean = static_cast<std::size_t>(std::lround(0.5 * log.velocity_mean_s / data.period_s));
  if (data.source == "velocity" && mean > 0) {
    data.weights = convolved(data.weights, mean_weights(mean));
    data.margin += mean;
  }
  if (data.source == "force") {
    take_force(log, data);
  }
}

/// The unfiltered vertical acceleration, from neighbouring samples. It is not filtered, because the prediction that is
/// computed from it is filtered later.
std::vector<double> vertical_acceleration(const FlightLog& log, const TranslationData& data) {
  std::vector<double> out(log.size, 0.0);
  const bool velocity = log.has(Signal::kVelocityZ);
  const std::vector<double>& z = log.of(velocity ? Signal::kVelocityZ : Signal::kPositionZ);
  for (std::size_t i = 1; i + 1 < z.size(); ++i) {
    out[i] = velocity ? (z[i + 1] - z[i - 1]) / (2.0 * data.period_s)
                      : (z[i + 1] - 2.0 * z[i] + z[i - 1]) / (data.period_s * data.period_s);
  }
  return out;
}

/// Offset [m/s^2] of the accelerometer along the body's z axis, for each flight. It is the least-squares difference of
/// the vertical acceleration by the accelerometer and by the measured motion. Zero if the accelerometer is also the
/// source of the motion.
std::vector<double> force_error_z(const FlightLog& log, const TranslationData& data) {
  std::vector<double> out(data.flights.size(), 0.0), weight(data.flights.size(), 0.0);
  if (data.source == "force") {
    return out;
  }
  const std::vector<double> upward = force_in_world(log, data)[2];
  for (std::size_t i = data.margin; i + data.margin < log.size; ++i) {
    if (data.valid[i] != 0) {
      const std::size_t flight = data.flight_of(i);
      out[flight] += data.direction[2][i] * (data.filtered(upward, i) - data.measured[2][i]);
      weight[flight] += data.direction[2][i] * data.direction[2][i];
    }
  }
  for (std::size_t flight = 0; flight < out.size(); ++flight) {
    out[flight] = weight[flight] > 0.0 ? out[flight] / weight[flight] : 0.0;
  }
  return out;
}

void take_thrust(const FlightLog& log, ThrustSource thrust_from, TranslationData& data) {
  const bool force = has_force(log);
  const std::vector<double> error = force ? force_error_z(log, data) : std::vector<double>{};
  data.thrust.assign(log.size, kStandardGravity_m_s2);
  const std::vector<double> upward = force ? std::vector<double>{} : vertical_acceleration(log, data);
  constexpr double kSteepest = 0.3;  // cosine of the tilt; beyond it the vertical no longer shows the thrust
  for (std::size_t i = 0; i < log.size; ++i) {
    const double upright = std::max(kSteepest, data.direction[2][i]);
    if (data.has_thrust) {
      data.thrust[i] = kStandardGravity_m_s2 * log.of(Signal::kThrustRatio)[i];
    } else if (thrust_from == ThrustSource::kWeight) {
      data.thrust[i] = kStandardGravity_m_s2 / upright;
    } else {
      data.thrust[i] =
          force ? log.of(Signal::kForceZ)[i] - error[data.flight_of(i)] : (upward[i] + kStandardGravity_m_s2) / upright;
    }
  }
  if (thrust_from == ThrustSource::kTangents) {
    take_tangents(log, data);
  }
}

void require(const FlightLog& log, bool there, const char* key, const char* what) {
  if (!there) {
    throw InputError(log.file, 0, key, what);
  }
}

/// 1 where one of the signals of the data was not sampled.
std::vector<std::uint8_t> gap_of_motion(const FlightLog& log, const TranslationData& data) {
  const Signal motion = data.source == "velocity"   ? Signal::kVelocityX
                        : data.source == "position" ? Signal::kPositionX
                                                    : Signal::kForceX;
  const Signal attitude = log.has3(Signal::kThrustDirX) ? Signal::kThrustDirX : Signal::kAttitudeRoll;
  return log.gap_of({motion, logs::offset(motion, 1), logs::offset(motion, 2), attitude, logs::offset(attitude, 1),
                     logs::offset(attitude, 2), Signal::kAttitudeYaw,
                     data.has_thrust ? Signal::kThrustRatio : Signal::kForceZ});
}

/// @throws InputError where a signal is missing that translation needs.
void check_signals(const FlightLog& log) {
  const bool has_attitude = log.has(Signal::kAttitudeRoll) && log.has(Signal::kAttitudePitch);
  require(log, has_attitude || log.has3(Signal::kThrustDirX), "attitude_roll",
          "translation needs attitude_roll and attitude_pitch, or thrust_dir_x, _y, _z");
  require(log, log.has3(Signal::kVelocityX) || log.has3(Signal::kPositionX) || has_force(log), "velocity_x",
          "translation needs velocity, position or force, all three axes of it");
}

/// The heading where it was logged, and the thrust's direction.
void take_directions(const FlightLog& log, TranslationData& data) {
  data.has_yaw = log.has(Signal::kAttitudeYaw);
  for (std::size_t i = 0; data.has_yaw && i < log.size; ++i) {
    data.heading_cosine[i] = std::cos(log.of(Signal::kAttitudeYaw)[i]);
    data.heading_sine[i] = std::sin(log.of(Signal::kAttitudeYaw)[i]);
  }
  data.direction.fill(std::vector<double>(log.size));
  if (!log.has3(Signal::kThrustDirX)) {
    body_axes(log, data);
    return;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    data.direction[c] = log.of(logs::offset(Signal::kThrustDirX, static_cast<int>(c)));
  }
}

/// Excludes samples whose filter would reach into a gap.
void mask_beside(const std::vector<std::uint8_t>& gap, TranslationData& data) {
  const std::size_t size = data.valid.size();
  for (std::size_t i = 0; i < std::min(size, gap.size()); ++i) {
    if (gap[i] != 0) {
      const std::size_t from = i > data.margin ? i - data.margin : 0;
      std::fill(data.valid.begin() + static_cast<std::ptrdiff_t>(from),
                data.valid.begin() + static_cast<std::ptrdiff_t>(std::min(i + data.margin + 1, size)), char{0});
    }
  }
}

}  // namespace

TranslationData::TranslationData(const FlightLog& log, ThrustSource thrust_from)
    : start_s(log.start_s),
      period_s(log.period_s),
      heading_cosine(log.size, 1.0),
      heading_sine(log.size, 0.0),
      valid(log.size, 1) {
  has_velocity = log.has3(Signal::kVelocityX);
  for (std::size_t k = 1; k < log.flights.size(); ++k) {
    flights.push_back(log.flights[k].begin);
  }
  check_signals(log);
  has_thrust = thrust_from == ThrustSource::kSetPoint;
  axes = has_thrust ? 3 : 2;
  if (thrust_from == ThrustSource::kVertical) {
    projection = has_force(log) ? ForceProjection::kAcrossThrust : ForceProjection::kOffVertical;
  }
  velocity.fill(std::vector<double>(log.size, 0.0));
  take_directions(log, *this);
  take_motion(log, *this);
  const std::vector<std::uint8_t> gap = gap_of_motion(log, *this);
  mask_unusable(log, gap, ground_times(log), 0.0, valid);
  mask_beside(gap, *this);
  take_thrust(log, thrust_from, *this);
}

std::size_t TranslationData::flight_of(std::size_t i) const {
  const auto after = std::upper_bound(flights.begin() + 1, flights.end(), i);
  return static_cast<std::size_t>(after - flights.begin()) - 1;
}

double TranslationData::filtered(const std::vector<double>& acceleration, std::size_t i) const {
  double sum = 0.0;
  for (std::size_t m = 0; m < weights.size(); ++m) {
    sum += weights[m] * acceleration[i + m - margin];
  }
  return sum;
}

namespace {

/// Removes the first seconds of each flight from the ranges. @returns the removed ranges.
std::vector<Range> taken_heads(const TranslationData& data, double head_s, std::vector<Range>& ranges) {
  std::sort(ranges.begin(), ranges.end());
  std::vector<double> left_s(data.flights.size(), head_s);
  std::vector<Range> heads;
  for (Range& range : ranges) {
    const double first = std::ceil((range.first - data.start_s) / data.period_s - 1e-6);
    double& left = left_s[data.flight_of(static_cast<std::size_t>(std::max(0.0, first)))];
    const double here_s = std::min(left, range.second - range.first);
    if (here_s > 0.0) {
      heads.emplace_back(range.first, range.first + here_s);
      range.first += here_s;
      left -= here_s;
    }
  }
  return heads;
}

}  // namespace

TranslationBlocks::TranslationBlocks(const TranslationData& of, const std::vector<Range>& all, double head_s)
    : data(&of) {
  std::vector<Range> ranges = all;
  if (head_s > 0.0) {
    const std::vector<Range> heads = taken_heads(of, head_s, ranges);
    head = std::make_shared<const TranslationBlocks>(of, heads);
  }
  const auto step = static_cast<std::size_t>(std::max(1L, std::lround(1.0 / (kRate_hz * of.period_s))));
  const auto length = static_cast<std::size_t>(std::lround(kBlock_s / of.period_s));
  sample_period_s = static_cast<double>(step) * of.period_s;
  for (const Range& range : ranges) {
    const double first = std::ceil((range.first - of.start_s) / of.period_s - 1e-6);
    const double last = std::ceil((range.second - of.start_s) / of.period_s - 1e-6);
    const auto end = static_cast<std::size_t>(std::clamp(last, 0.0, static_cast<double>(of.valid.size())));
    auto begin = static_cast<std::size_t>(std::max(first, 0.0));
    for (; begin + length / 2 < end; begin += length) {
      Block block{.samples = {}, .row = rows};
      for (std::size_t i = begin; i < std::min(end, begin + length); i += step) {
        if (of.usable(i)) {
          block.samples.push_back(i);
        }
      }
      if (2 * block.samples.size() * step >= length) {
        rows += of.axes * block.samples.size();
        blocks.push_back(std::move(block));
      }
    }
  }
}

}  // namespace m100::lab::identify
