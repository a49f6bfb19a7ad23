// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/covariance_inflation.h"

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::est {
namespace {

constexpr double kSmooths_s = 0.05;  // time constant that smooths the errors; shorter than the observer's lag (0.15 s)
constexpr double kMaxShare = 0.5;    // largest weight of a single pose in the smoothed errors
constexpr double kMemory_s = 3.0;    // of the mean products: a gust or two
constexpr double kMaxNisShare = 1.0 / 30.0;  // of one pose in the mean NIS: then it errs by 0.18 at most, one sigma
constexpr double kMin_s = 0.005;             // half a tick: poses are used once per tick
constexpr double kFresh_s = 0.1;
constexpr double kGrows_s = 1.0;   // longest time for which the added variances grow
constexpr double kMinKept = 0.25;  // smallest factor of the filter's own variance: half of its sigma

template <typename T>
T share(T step_s, double memory_s, double most) {
  const T linear = step_s * static_cast<T>(1.0 / memory_s);
  return linear < static_cast<T>(most) ? linear : static_cast<T>(most);
}

template <typename T>
T positive(T value) {
  return value > T(0) ? value : T(0);
}

}  // namespace

template <typename T>
typename CovarianceInflation<T>::Products CovarianceInflation<T>::products(const Error& e) {
  return {.pp = e.p_m * e.p_m,
          .pv = e.p_m * e.v_m_s,
          .vv = e.v_m_s * e.v_m_s,
          .pa = e.p_m * e.a_m_s2,
          .va = e.v_m_s * e.a_m_s2,
          .aa = e.a_m_s2 * e.a_m_s2};
}

template <typename T>
void CovarianceInflation<T>::update(T innovation_m, T correction_m, T correction_m_s, T nis, T interval_s) {
  const T step_s = interval_s > static_cast<T>(kMin_s) ? interval_s : static_cast<T>(kMin_s);
  const Error raw{.p_m = innovation_m, .v_m_s = correction_m / step_s, .a_m_s2 = correction_m_s / step_s};
  const T smooths = share(step_s, kSmooths_s, kMaxShare);
  now_.p_m += smooths * (raw.p_m - now_.p_m);
  now_.v_m_s += smooths * (raw.v_m_s - now_.v_m_s);
  now_.a_m_s2 += smooths * (raw.a_m_s2 - now_.a_m_s2);
  // White noise of the poses with mean square n leaves k n in the square of now_, k = smooths / (2 - smooths).
  const T keeps = smooths / (T(2) - smooths);
  const T scale = T(1) / (T(1) - keeps);
  const Products smooth = products(now_);
  const Products noisy = products(raw);
  const T remembers = share(step_s, kMemory_s, 1.0);
  const auto mean = [=](T& value, T seen, T all) { value += remembers * ((seen - keeps * all) * scale - value); };
  mean(mean_.pp, smooth.pp, noisy.pp);
  mean(mean_.pv, smooth.pv, noisy.pv);
  mean(mean_.vv, smooth.vv, noisy.vv);
  mean(mean_.pa, smooth.pa, noisy.pa);
  mean(mean_.va, smooth.va, noisy.va);
  mean(mean_.aa, smooth.aa, noisy.aa);
  nis_ += share(step_s, kMemory_s, kMaxNisShare) * (nis - nis_);
}

template <typename T>
typename CovarianceInflation<T>::Covariance CovarianceInflation<T>::inflated(const Covariance& own, T age_s, T since_s,
                                                                             bool force_known) const {
  const T kept = since_s > static_cast<T>(kFresh_s) ? T(1) : core::clamp(nis_, static_cast<T>(kMinKept), T(1));
  constexpr T kMax = static_cast<T>(kGrows_s);
  const T age = age_s < kMax ? age_s : kMax;
  const T since = since_s < kMax ? since_s : kMax;
  const T half = T(0.5) * age * age;
  Products m = mean_;
  if (force_known) {
    constexpr T kOffset = static_cast<T>(kForceOffset_m_s2);
    m.pa = m.va = T(0);
    m.aa = kOffset * kOffset;
  }
  const T pp =
      positive(m.pp + T(2) * (age * m.pv + half * (m.pa + age * m.va)) + age * age * m.vv + half * half * m.aa);
  const T vv = positive(m.vv + since * (T(2) * m.va + since * m.aa));
  return {.pp_m2 = kept * own.pp_m2 + pp, .pv_m2_s = kept * own.pv_m2_s, .vv_m2_s2 = kept * own.vv_m2_s2 + vv};
}

template class CovarianceInflation<float>;
template class CovarianceInflation<double>;

}  // namespace m100::est
