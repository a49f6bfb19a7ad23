// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace m100::sysid {

/// The newest eleven samples of an axis, and the quadratic through them.
template <typename Real>
class SampleWindow {
 public:
  static constexpr std::size_t kHalf = 5;

  struct Sample {
    Real measured{0};
    Real command{0};  ///< static law of the same sample
  };

  void add(const Sample& sample) {
    newest_ = (newest_ + 1) % samples_.size();
    samples_[newest_] = sample;
    filled_ += filled_ < samples_.size() ? 1U : 0U;
  }
  void clear() { filled_ = 0; }

  bool has_middle() const { return filled_ > kHalf; }
  bool is_full() const { return filled_ == samples_.size(); }
  /// The sample of kHalf samples ago.
  const Sample& middle() const { return samples_[(newest_ + samples_.size() - kHalf) % samples_.size()]; }

  struct Start {
    Real value{0};
    Real slope_per_s{0};
  };
  /// Value and slope of the least-squares quadratic at the middle, x = 0. Sums over x = -5 .. 5: of 1, 11; of x^2, 110;
  /// of x^4, 1958.
  Start start(Real sample_period_s) const;

 private:
  std::array<Sample, 2 * kHalf + 1> samples_{};  ///< ring
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
};

template <typename Real>
typename SampleWindow<Real>::Start SampleWindow<Real>::start(Real sample_period_s) const {
  Real m0 = Real(0);
  Real m1 = Real(0);
  Real m2 = Real(0);
  const std::size_t oldest = (newest_ + 1) % samples_.size();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Real y = samples_[(oldest + i) % samples_.size()].measured;
    const Real x = static_cast<Real>(i) - static_cast<Real>(kHalf);
    m0 += y;
    m1 += x * y;
    m2 += x * x * y;
  }
  return {.value = (Real(1958) * m0 - Real(110) * m2) / Real(9438), .slope_per_s = m1 / (Real(110) * sample_period_s)};
}

}  // namespace m100::sysid
