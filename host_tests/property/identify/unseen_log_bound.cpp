// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/unseen_log_bound.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/eigen.h"
// After our eigen.h, which redirects Eigen's assertions.
#include <Eigen/Cholesky>

namespace m100::host_tests {
namespace {

using Column = Eigen::VectorXd;

/// Innovations of a first-order process with white noise, each divided by its standard deviation.
Column whitened(const Column& values, const UnseenLogNoise& noise) {
  const double keep = std::exp(-noise.row_s / noise.air_s);
  const double air = noise.air * noise.air;
  const double white = std::max(noise.white * noise.white, 1e-12 * air);
  double variance = air;
  double mean = 0.0;
  Column out(values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double sum = variance + white;
    const double innovation = values(k) - mean;
    out(k) = innovation / std::sqrt(sum);
    mean = keep * (mean + variance / sum * innovation);
    variance = keep * keep * variance * white / sum + (1.0 - keep * keep) * air;
  }
  return out;
}

struct Free {
  double oracle::AxisParameters::*member;
  double step;
  double low;
};

class Believed {
 public:
  Believed(const std::vector<double>& truth, const std::vector<std::size_t>& rows, const UnseenLogSticks& sticks,
           const UnseenLogNoise& noise)
      : truth_(truth), rows_(rows), sticks_(sticks), noise_(noise) {}

  /// True minus believed response, whitened.
  Column difference(const oracle::AxisParameters& traits, double offset) const {
    const std::vector<double> all = response_of(traits, traits, 1e300, sticks_);
    Column out(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      out(static_cast<Eigen::Index>(k)) = truth_[k] - all[std::min(rows_[k], all.size() - 1)] - offset;
    }
    return whitened(out, noise_);
  }

 private:
  const std::vector<double>& truth_;
  const std::vector<std::size_t>& rows_;
  const UnseenLogSticks& sticks_;
  const UnseenLogNoise& noise_;
};

std::vector<Free> free_of(const oracle::AxisParameters& start, const std::vector<std::string>& declared) {
  const auto has = [&](const char* name) {
    return std::find(declared.begin(), declared.end(), name) != declared.end();
  };
  std::vector<Free> out{{&oracle::AxisParameters::gain, 0.01 * start.gain, -1.0},
                        {&oracle::AxisParameters::frequency_rad_s, 0.01 * start.frequency_rad_s, 0.3},
                        {&oracle::AxisParameters::damping, 0.01, 0.05}};
  if (has("transport_delay")) {
    out.push_back({&oracle::AxisParameters::delay_s, 0.002, 0.0});
  }
  if (has("dead_zone")) {
    out.push_back({&oracle::AxisParameters::dead_zone_counts, 1.0, 0.0});
  }
  if (has("trim_offset")) {
    out.push_back({&oracle::AxisParameters::trim_counts, 1.0, -600.0});
  }
  return out;
}

}  // namespace

double evidence_of(const std::vector<double>& truth, const std::vector<std::size_t>& rows,
                   const UnseenLogSticks& sticks, oracle::AxisParameters believed,
                   const std::vector<std::string>& declared, const UnseenLogNoise& noise) {
  constexpr int kSteps = 20;
  const Believed model(truth, rows, sticks, noise);
  const std::vector<Free> free = free_of(believed, declared);
  const auto count = static_cast<Eigen::Index>(free.size());
  const Column one = whitened(Column::Ones(static_cast<Eigen::Index>(rows.size())), noise);
  double offset = 0.0;
  Column left = model.difference(believed, offset);
  double least = left.squaredNorm();
  for (int step = 0; step < kSteps; ++step) {
    Eigen::MatrixXd slopes(left.size(), count + 1);
    for (Eigen::Index k = 0; k < count; ++k) {
      oracle::AxisParameters moved = believed;
      moved.*free[static_cast<std::size_t>(k)].member += free[static_cast<std::size_t>(k)].step;
      slopes.col(k) = (left - model.difference(moved, offset)) / free[static_cast<std::size_t>(k)].step;
    }
    slopes.col(count) = one;
    const Eigen::MatrixXd normal = slopes.transpose() * slopes;
    // Damped: with a stick that uses only two deflections, gain and dead zone cannot be separated, and the undamped
    // step diverges along their common direction.
    oracle::AxisParameters best = believed;
    double best_offset = offset;
    double least_yet = least;
    for (const double damping : {1e-9, 1e-4, 1e-2, 1.0, 100.0}) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1.0 + damping;
      const Column move = damped.ldlt().solve(slopes.transpose() * left);
      oracle::AxisParameters tried = believed;
      for (Eigen::Index k = 0; k < count; ++k) {
        const Free& one_of = free[static_cast<std::size_t>(k)];
        tried.*one_of.member = std::max(one_of.low, tried.*one_of.member + move(k));
      }
      const double moved_offset = offset + move(count);
      const double power = model.difference(tried, moved_offset).squaredNorm();
      if (power < least_yet) {
        best = tried;
        best_offset = moved_offset;
        least_yet = power;
      }
    }
    const double gained = least - least_yet;
    believed = best;
    offset = best_offset;
    least = least_yet;
    left = model.difference(believed, offset);
    if (gained < 0.01) {
      break;
    }
  }
  return least;
}

}  // namespace m100::host_tests
