// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/response_fit.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::sysid {

template <typename Real>
void ResponseFit<Real>::begin() {
  sum_ = {};
  y_ = s_ = e_ = Real(0);
  samples_ = 0;
}

template <typename Real>
void ResponseFit<Real>::add(Real predicted, Real slope, Real error) {
  y0_ = samples_ == 0 ? predicted : y0_;
  const Real y = predicted - y0_;
  sum_.ee += error * error;
  sum_.yy += y * y;
  sum_.ss += slope * slope;
  sum_.ey += error * y;
  sum_.es += error * slope;
  sum_.ys += y * slope;
  y_ += y;
  s_ += slope;
  e_ += error;
  ++samples_;
}

template <typename Real>
bool ResponseFit<Real>::end() {
  M100_ASSERT(samples_ > 0);  // a block of nothing would put not-a-number into the ring
  const Real share = Real(1) / static_cast<Real>(samples_);
  const Real y = y_ * share;
  const Real s = s_ * share;
  const Real e = e_ * share;
  ring_[blocks_ % kBlocks] = {.ee = sum_.ee * share - e * e,
                              .yy = sum_.yy * share - y * y,
                              .ss = sum_.ss * share - s * s,
                              .ey = sum_.ey * share - e * y,
                              .es = sum_.es * share - e * s,
                              .ys = sum_.ys * share - y * s};
  ++blocks_;
  if (blocks_ < kBlocks) {
    return false;
  }
  solve();
  return true;
}

template <typename Real>
void ResponseFit<Real>::solve() {
  Moments mean;
  for (const Moments& block : ring_) {
    mean.ee += block.ee / static_cast<Real>(kBlocks);
    mean.yy += block.yy / static_cast<Real>(kBlocks);
    mean.ss += block.ss / static_cast<Real>(kBlocks);
    mean.ey += block.ey / static_cast<Real>(kBlocks);
    mean.es += block.es / static_cast<Real>(kBlocks);
    mean.ys += block.ys / static_cast<Real>(kBlocks);
  }
  const Real determinant = mean.yy * mean.ss - mean.ys * mean.ys;
  report_ = {};
  // A prediction that is constant or proportional to its slope determines nothing (Cauchy-Schwarz: determinant >= 0).
  if (!(determinant > Real(1e-3) * mean.yy * mean.ss)) {
    return;
  }
  const Real on_y = (mean.ey * mean.ss - mean.es * mean.ys) / determinant;
  const Real on_s = (mean.es * mean.yy - mean.ey * mean.ys) / determinant;
  const Real rest = mean.ee - on_y * mean.ey - on_s * mean.es;
  const Real duration_s = static_cast<Real>(kBlocks * samples_) * sample_period_s_;
  const Real variance = (rest > Real(0) ? rest : Real(0)) * Real(2) * kMemory_s / duration_s;
  report_ = {.gain = -on_y,
             .gain_sigma = core::sqrt(variance * mean.ss / determinant),
             .late_s = on_s,
             .late_sigma_s = core::sqrt(variance * mean.yy / determinant),
             .swing = core::sqrt(mean.yy)};
}

template class ResponseFit<float>;
template class ResponseFit<double>;

}  // namespace m100::sysid
