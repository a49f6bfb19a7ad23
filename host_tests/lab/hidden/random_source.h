// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "host_tests/lab/hidden/stick_response.h"

namespace m100::lab::hidden {

/// The random numbers of one flight; each seed gives other numbers.
class RandomSource {
 public:
  explicit RandomSource(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15ULL + 12345) {}
  double between(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine_); }
  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(engine_); }

 private:
  std::mt19937_64 engine_;
};

/// First-order coloured noise with a given standard deviation and correlation time.
class GaussMarkovNoise {
 public:
  GaussMarkovNoise(double sigma, double memory_s)
      : keep_(std::exp(-kStep_s / memory_s)), kick_(sigma * std::sqrt(1 - keep_ * keep_)) {}
  double step(RandomSource& rng) { return value_ = keep_ * value_ + rng.normal(kick_); }
  double value() const { return value_; }

 private:
  double keep_, kick_, value_ = 0.0;
};

}  // namespace m100::lab::hidden
