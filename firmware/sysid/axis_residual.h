// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/model/stick_axis.h"
#include "firmware/sysid/axis_dynamics.h"
#include "firmware/sysid/delayed_command.h"
#include "firmware/sysid/response_fit.h"
#include "firmware/sysid/sample_window.h"

namespace m100::sysid {

/// The residual of a channel. It names no cause: only identification of the whole log finds one.
template <typename Real>
struct ResidualReport {
  Real block_rms = Real(0);        ///< of the last complete block, unit of the axis
  Real ratio = Real(0);            ///< of the last block: rms residual about its mean, over that of a right model
  std::uint32_t blocks = 0;        ///< complete blocks so far
  std::uint32_t blocks_over = 0;   ///< the newest blocks in a row that are over the limit
  ResponseError<Real> response;    ///< gain and delay over the last three blocks
  bool response_departed = false;  ///< the stick moved enough, and gain or delay differ from the model's
  bool departed = false;           ///< no longer follows the model: by the response, two blocks over, or one far over
};

/// Computes the residual of `m100-lab identify` in flight, for one stick axis: the simulation error over blocks of 2.5
/// s, each started from the measured state (quadratic through eleven samples). It works five samples late, because the
/// quadratic is centred.
/// Memory: fixed, about 1.4 kB for Real = double.
/// Cost: per sample one static law and one step, some 80 flops; 100 more at a block's start and end.
///
/// The expected error of a right model is the root of the sum of the squares of: the floor of the identified axis, the
/// prediction's slope times kTiming_s (a line with clocks of its own delays unevenly), and its swing times kGain (half
/// of an identified interval). est::TrimMonitor handles offsets: here errors are taken about their mean in the block.
template <typename Real>
class AxisResidual {
 public:
  static constexpr std::size_t kBlock = 250;  ///< samples
  static constexpr std::size_t kSettle = 50;  ///< samples in which an error of the start fades
  static constexpr Real kTiming_s = Real(0.02);
  static constexpr Real kGain = Real(0.1);

  /// @param expected_rms  floor: residual of the identified axis on the validation part, unit of the axis, > 0
  AxisResidual(const model::StickAxis& axis, Real expected_rms, Real sample_period_s);

  /// One tick. Sticks in counts from neutral, see ResidualMonitor::Sample; `measured` in the unit of the axis.
  void update(Real stick_counts, Real other_counts, Real measured);
  /// No measurement in this tick, or a stick that is not ours: discards the block; a new one starts after 11 samples.
  void interrupt();
  const ResidualReport<Real>& report() const { return report_; }

 private:
  void process(const typename SampleWindow<Real>::Sample& sample);
  void begin_block();
  void end_block();
  Real lead_zero_s_;
  Real expected_rms_;
  Real sample_period_s_;
  model::StickLaw<Real> law_;
  AxisDynamics<Real> dynamics_;
  SampleWindow<Real> window_;
  DelayedCommand<Real> delayed_;
  std::uint32_t sample_ = 0;
  std::size_t in_block_ = 0;
  Real before_ = Real(0);
  Real sum_ = Real(0);
  Real predicted_ = Real(0);  ///< in the sample before
  bool running_ = false;
  ResponseFit<Real> fit_;
  ResidualReport<Real> report_;
};

extern template class AxisResidual<float>;
extern template class AxisResidual<double>;

}  // namespace m100::sysid
