// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace m100::sysid {

/// What a least-squares fit says of a response against its prediction y: measured(t) = (1 + gain) y(t - late).
template <typename Real>
struct ResponseError {
  Real gain = Real(0);          ///< share by which the response is larger than predicted
  Real gain_sigma = Real(0);    ///< its standard error
  Real late_s = Real(0);        ///< how much later than predicted it comes
  Real late_sigma_s = Real(0);  ///< its standard error
  Real swing = Real(0);         ///< standard deviation of the prediction, unit of the axis
};

/// Gain and time of a response against its prediction, over the last three blocks: the error (prediction less
/// measurement) is regressed on the prediction and its slope, each about its mean in the block, so that an offset says
/// nothing. Unlike the size of the error it is not masked by what wanders without any stick: a third of the gain shows
/// at swings at which it is smaller than that.
///
/// Blind where the loop answers the wander itself (hover): there the prediction follows from the error, not the other
/// way round. So a fit with little swing must not be believed; who asks decides how much is enough.
///
/// Memory: 28 numbers. Cost: some 12 flops a sample, 40 at a block's end. Errors: none; `Real` is float or double.
template <typename Real>
class ResponseFit {
 public:
  static constexpr std::size_t kBlocks = 3;
  /// Over which an error is correlated with itself, as long as the slowest axis' response: neighbouring samples tell
  /// the same. One statement counts for twice this time.
  static constexpr Real kMemory_s = Real(0.25);

  explicit ResponseFit(Real sample_period_s) : sample_period_s_(sample_period_s) {}

  /// A block begins: what the last one had gathered, but not ended, is dropped.
  void begin();
  /// One sample of the block.
  /// @param predicted unit of the axis; @param slope of the prediction, unit per s; @param error prediction less
  ///        measurement, unit of the axis. All finite.
  void add(Real predicted, Real slope, Real error);
  /// The block is whole. @return whether three blocks are there, and report() is of them.
  bool end();
  const ResponseError<Real>& report() const { return report_; }

  /// Of the block that ended last, each about its mean: mean squares of error, prediction and its slope.
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
  Real y0_ = Real(0);  ///< of the block's first sample: keeps the squares small
  Real y_ = Real(0), s_ = Real(0), e_ = Real(0);
  std::uint32_t samples_ = 0;
  ResponseError<Real> report_;
};

}  // namespace m100::sysid
