// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace m100::sim {

/// Seeded random numbers that are the same with every compiler and library (std::normal_distribution is not).
/// SplitMix64. Each consumer takes its own stream by name, so that an additional draw does not change other consumers.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream) : state_(seed * 0x9E3779B97F4A7C15ULL + 0x1234567ULL) {
    for (const char letter : stream) {
      state_ = (state_ ^ static_cast<std::uint8_t>(letter)) * 0x100000001B3ULL;
    }
  }

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }

  /// Mean 0, variance 1 (Box-Muller; the second number of each pair is kept).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// First-order Gauss-Markov noise of a stated standard deviation and correlation time, exact for any step.
class ColouredNoise {
 public:
  ColouredNoise(double sigma, double correlation_s) : sigma_(sigma), correlation_s_(correlation_s) {}
  double advance(double step_s, Random& random) {
    if (sigma_ == 0.0) {
      return 0.0;
    }
    const double keep = std::exp(-step_s / correlation_s_);
    value_ = keep * value_ + sigma_ * std::sqrt(1.0 - keep * keep) * random.normal();
    return value_;
  }
  double value() const { return value_; }
  /// Changes the parameters; the noise continues from its present value.
  void set_parameters(double sigma, double correlation_s) {
    sigma_ = sigma;
    correlation_s_ = correlation_s;
  }

 private:
  double sigma_;
  double correlation_s_;
  double value_ = 0.0;
};

/// A held quantity that wanders: damping 0.5, stated natural frequency, driven by white noise so that its
/// standard deviation is sigma and that of its rate sigma times the frequency. Smooth: its rate exists.
class Wander {
 public:
  Wander(double sigma, double frequency_rad_s) : sigma_(sigma), frequency_rad_s_(frequency_rad_s) {}
  void advance(double step_s, Random& random) {
    constexpr double kDamping = 0.5;
    const double w = frequency_rad_s_;
    const double kick = sigma_ * std::sqrt(4.0 * kDamping * w * w * w / step_s) * random.normal();
    rate_ += step_s * (kick - w * w * value_ - 2.0 * kDamping * w * rate_);
    value_ += step_s * rate_;
  }
  double value() const { return value_; }
  double rate() const { return rate_; }
  void set_sigma(double sigma) { sigma_ = sigma; }

 private:
  double sigma_;
  double frequency_rad_s_;
  double value_ = 0.0;
  double rate_ = 0.0;
};

}  // namespace m100::sim
