// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/periodic_force.h"
#include "host_tests/lab/printed.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::lab::identify {
namespace {

constexpr double kOwnMotionShare = 0.15;
constexpr double kHoverShare = 0.30;
constexpr double kHover_m_s = 0.5;
constexpr double kHighest_hz = 5.0;
constexpr double kPeriodsInSpan = 2.5;
constexpr std::size_t kFewestHovering = 100;

double omega(double frequency_hz) { return 2.0 * std::numbers::pi * frequency_hz; }

/// Subtracts the best straight line over time.
std::vector<double> detrended(const TimeSeries& series) {
  const auto n = static_cast<double>(series.values.size());
  double t_mean = 0.0;
  double v_mean = 0.0;
  for (std::size_t k = 0; k < series.values.size(); ++k) {
    t_mean += series.time_s[k] / n;
    v_mean += series.values[k] / n;
  }
  double tt = 0.0;
  double tv = 0.0;
  for (std::size_t k = 0; k < series.values.size(); ++k) {
    tt += (series.time_s[k] - t_mean) * (series.time_s[k] - t_mean);
    tv += (series.time_s[k] - t_mean) * (series.values[k] - v_mean);
  }
  std::vector<double> out(series.values.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = series.values[k] - v_mean - (tt > 0 ? tv / tt : 0.0) * (series.time_s[k] - t_mean);
  }
  return out;
}

struct Sinusoid {
  double cosine = 0.0;
  double sine = 0.0;
  double explained = 0.0;  // sum of squares
};

Sinusoid fit_sinusoid(const std::vector<double>& time_s, const std::vector<double>& values, double frequency_hz) {
  double cc = 0.0;
  double ss = 0.0;
  double cs = 0.0;
  double cv = 0.0;
  double sv = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double c = std::cos(omega(frequency_hz) * time_s[k]);
    const double s = std::sin(omega(frequency_hz) * time_s[k]);
    cc += c * c;
    ss += s * s;
    cs += c * s;
    cv += c * values[k];
    sv += s * values[k];
  }
  const double determinant = cc * ss - cs * cs;
  if (!(determinant > 1e-9)) {
    return {};
  }
  Sinusoid out{(ss * cv - cs * sv) / determinant, (cc * sv - cs * cv) / determinant, 0.0};
  out.explained = out.cosine * cv + out.sine * sv;
  return out;
}

double power(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) {
    sum += v * v;
  }
  return sum;
}

using BothAxes = std::array<TimeSeries, 2>;

/// The residual, divided into the parts where the vehicle moves and where it hovers.
struct Parted {
  BothAxes moving;
  BothAxes hovering;
};

Parted parted(const VehicleMotion& motion) {
  Parted out;
  const std::size_t count = motion.speed_m_s.size();
  const auto at_rest = [&](std::size_t k) { return motion.speed_m_s[k] < kHover_m_s; };
  std::size_t resting = 0;
  for (std::size_t k = 0; k < count; ++k) {
    resting += at_rest(k) ? 1U : 0U;
  }
  // In a log that hovers for more than 70 % of its time, the first half is used as "moving".
  const bool all_hover = 10 * resting > 7 * count;
  for (std::size_t n = 0; n < 2; ++n) {
    for (std::size_t k = 0; k < count; ++k) {
      const bool fits = all_hover ? k < count / 2 : !at_rest(k);
      TimeSeries& into = fits ? out.moving[n] : out.hovering[n];
      into.time_s.push_back(motion.residual[n].time_s[k]);
      into.values.push_back(motion.residual[n].values[k]);
    }
  }
  return out;
}

/// Whether an oscillation that is fitted where the vehicle moves predicts enough of the residual where it hovers.
bool hovering_shows(const VehicleMotion& motion) {
  const auto [moving, hovering] = parted(motion);
  if (hovering[0].values.size() < kFewestHovering || moving[0].values.size() < kFewestHovering) {
    return false;
  }
  double before = 0.0;
  double after = 0.0;
  for (std::size_t n = 0; n < 2; ++n) {
    const Sinusoid line = fit_sinusoid(moving[n].time_s, detrended(moving[n]), motion.frequency_hz);
    const std::vector<double> rest = detrended(hovering[n]);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const double phase = omega(motion.frequency_hz) * hovering[n].time_s[k];
      const double left = rest[k] - line.cosine * std::cos(phase) - line.sine * std::sin(phase);
      before += rest[k] * rest[k];
      after += left * left;
    }
  }
  return after < (1.0 - kHoverShare) * before;
}

}  // namespace

double share_at(const TimeSeries& series, double frequency_hz) {
  const std::vector<double> values = detrended(series);
  const double all = power(values);
  return all > 0.0 ? fit_sinusoid(series.time_s, values, frequency_hz).explained / all : 0.0;
}

SpectralPeak strongest_peak(const std::vector<TimeSeries>& series) {
  SpectralPeak best;
  if (series.empty() || series[0].time_s.size() < 8) {
    return best;
  }
  const auto [first, last] = std::minmax_element(series[0].time_s.begin(), series[0].time_s.end());
  const double span = *last - *first;
  std::vector<std::vector<double>> values;
  double all = 0.0;
  for (const TimeSeries& one : series) {
    values.push_back(detrended(one));
    all += power(values.back());
  }
  for (double f = kPeriodsInSpan / span; f < kHighest_hz; f += 0.25 / span) {
    double explained = 0.0;
    for (std::size_t n = 0; n < series.size(); ++n) {
      explained += fit_sinusoid(series[n].time_s, values[n], f).explained;
    }
    if (all > 0.0 && explained / all > best.share) {
      best = {f, explained / all};
    }
  }
  return best;
}

std::string check_vehicle_motion(const VehicleMotion& motion) {
  std::string worst;
  double maximum = kOwnMotionShare;
  for (const VehicleMotion::Channel& channel : motion.channels) {
    TimeSeries series{.time_s = motion.residual[0].time_s, .values = channel.values};
    if (channel.moved_by_axis >= 0) {
      // A force c cos(wt) + s sin(wt) moves the velocity by (c sin(wt) - s cos(wt)) / w.
      const auto& force = motion.force[static_cast<std::size_t>(channel.moved_by_axis)];
      const double w = omega(motion.frequency_hz);
      for (std::size_t k = 0; k < series.values.size(); ++k) {
        const double phase = w * series.time_s[k];
        series.values[k] -= (force[0] * std::sin(phase) - force[1] * std::cos(phase)) / w;
      }
    }
    const double share = share_at(series, motion.frequency_hz);
    if (share > maximum) {
      maximum = share;
      worst = channel.name;
    }
  }
  if (worst.empty() || (!motion.speed_m_s.empty() && hovering_shows(motion))) {
    return "";
  }
  return printed("%s has %.0f %% of its power at %.2f Hz", worst.c_str(), 100.0 * maximum, motion.frequency_hz);
}

}  // namespace m100::lab::identify
