// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace m100::sysid {

/// Least-squares fit of a response to its prediction y: measured(t) = (1 + gain) y(t - late).
template <typename Real>
struct ResponseError {
  Real gain = Real(0);          ///< share by which the response is larger than predicted
  Real gain_sigma = Real(0);    ///< its standard error
  Real late_s = Real(0);        ///< how much later than predicted the response is
  Real late_sigma_s = Real(0);  ///< its standard error
  Real swing = Real(0);         ///< standard deviation of the prediction, unit of the axis
};

/// Estimates gain and delay of a response relative to its prediction, over the last three blocks: the error (prediction
/// less measurement) is regressed on the prediction and its slope, each about its mean in the block, so that an offset
/// has no influence. Unlike the size of the error, the fit is not masked by a wander that no stick causes: it shows an
/// error of a third of the gain even for movements so small that the error is smaller than the wander.
///
/// Blind where the loop reacts to the wander itself (hover): there the prediction follows from the error, not the other
/// way round. A fit to small movements is not reliable; the caller decides how much is enough.
///
/// Memory: 34 numbers, 2 counts. Cost: some 12 flops a sample, 40 at a block's end. `Real` is float or double.
template <typename Real>
class ResponseFit {
 public:
  static constexpr std::size_t kBlocks = 3;
  /// Correlation time of the error, as long as the slowest axis' response: neighbouring samples are not independent.
  /// One independent sample covers twice this time.
  static constexpr Real kMemory_s = Real(0.25);

  explicit ResponseFit(Real sample_period_s) : sample_period_s_(sample_period_s) {}

  /// Begins a block; drops the samples of a block that has not ended.
  void begin();
  /// One sample of the block.
  /// @param predicted unit of the axis; @param slope of the prediction, unit per s; @param error prediction less
  ///        measurement, unit of the axis. All finite.
  void add(Real predicted, Real slope, Real error);
  /// Ends the block.
  /// @returns whether there are three blocks, so that report() is valid
  bool end();
  const ResponseError<Real>& report() const { return report_; }

  /// Mean squares of error, prediction and its slope, each about its mean, in the block that ended last.
  Real block_error() const { return newest().ee; }
  Real block_swing() const { return newest().yy; }
  Real block_slope() const { return newest().ss; }

 private:
  /// Means of the products, each factor about its mean.
  struct Moments {
    Real ee = Real(0), yy = Real(0), ss = Real(0), ey = Real(0), es = Real(0), ys = Real(0);
  };
  const Moments& newest() const { return ring_[(blocks_ + kBlocks - 1) % kBlocks]; }
  void solve();

  Real sample_period_s_;
  std::array<Moments, kBlocks> ring_{};
  std::uint32_t blocks_ = 0;
  Moments sum_;
  Real y0_ = Real(0);  ///< prediction of the block's first sample: keeps the squares small
  Real y_ = Real(0), s_ = Real(0), e_ = Real(0);
  std::uint32_t samples_ = 0;
  ResponseError<Real> report_;
};

}  // namespace m100::sysid
