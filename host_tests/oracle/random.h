// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace m100::oracle {

/// Random numbers from one seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * uniform_(engine_); }
  double normal() { return normal_(engine_); }
  /// Forgets the second number of a pair: what follows does not depend on whether it was drawn.
  void drop_pair() { normal_.reset(); }
  double sign() { return uniform_(engine_) < 0.5 ? -1.0 : 1.0; }
  bool one_in(double count) { return uniform_(engine_) * count < 1.0; }
  template <typename Value>
  Value any_of(const std::vector<Value>& values) {
    return values[static_cast<std::size_t>(uniform_(engine_) * static_cast<double>(values.size()))];
  }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::normal_distribution<double> normal_;
};

/// First-order coloured noise with a given standard deviation and correlation time.
class GaussMarkovNoise {
 public:
  GaussMarkovNoise(double sigma, double memory_s, double step_s)
      : keep_(std::exp(-step_s / memory_s)), kick_(sigma * std::sqrt(1.0 - keep_ * keep_)), sigma_(sigma) {}
  /// Begins with a value of the given standard deviation; otherwise it begins at zero.
  void start(Random& rng) { value_ = sigma_ * rng.normal(); }
  void step(Random& rng) { value_ = keep_ * value_ + kick_ * rng.normal(); }
  double value() const { return value_; }

 private:
  double keep_, kick_, sigma_, value_ = 0.0;
};

}  // namespace m100::oracle
