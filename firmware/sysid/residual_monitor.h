// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/model/vehicle.h"
#include "firmware/sysid/axis_dynamics.h"
#include "firmware/sysid/response_fit.h"

namespace m100::sysid {

/// The residual of a channel. It names no cause: that takes the whole log and a host.
template <typename Real>
struct ResidualReport {
  Real block_rms = Real(0);        ///< of the last complete block, unit of the axis
  Real ratio = Real(0);            ///< at the block's end, residual about its mean over that of a right model
  std::uint32_t blocks = 0;        ///< complete blocks so far
  std::uint32_t blocks_over = 0;   ///< the newest blocks in a row that are over the limit
  ResponseError<Real> response;    ///< gain and delay over the last three blocks
  bool response_departed = false;  ///< the stick moved enough, and gain or delay differ from the model's
  bool departed = false;           ///< no longer follows the model: by the response, two blocks over, or one far over
};

/// Computes the residual of `m100-lab identify` in flight, for one stick axis: the simulation error over blocks of 2.5
/// s, each started from the measured state (quadratic through eleven samples). It works five samples late, because the
/// quadratic is centred.
/// Memory: fixed, about 1.6 kB for Real = double.
/// Cost: per sample one static law and one step, some 80 flops; 100 more at a block's start and end.
///
/// Expected of a right model at a block's end: the floor of the identified axis, the prediction's slope times kTiming_s
/// (of a line with clocks of its own) and its swing times kGain (half of an identified interval). est::TrimMonitor
/// handles offsets: here squares are taken about their mean in the block.
template <typename Real>
class AxisResidual {
 public:
  static constexpr std::size_t kHalfWindow = 5;
  static constexpr std::size_t kBlock = 250;  ///< samples
  static constexpr std::size_t kDelay = 64;   ///< most samples of transport delay, plus one
  static constexpr std::size_t kSettle = 50;  ///< samples in which an error of the start fades
  static constexpr Real kTiming_s = Real(0.02);
  static constexpr Real kGain = Real(0.1);
  static constexpr Real kLimit = Real(2.5);   ///< times the expected residual: over
  static constexpr Real kFarLimit = Real(5);  ///< times the expected residual: departed at once
  /// The response has departed when gain or delay exceed these limits by three standard errors. Delay: that of a
  /// healthy aircraft. A tired battery takes 12 % of a loop's frequency, a load of 0.4 kg another 6 %; 2 zeta / w is
  /// then longer by 33 ms. (60 ms must be noticed.) Gain: midway between the error of an identified gain (10 %) and the
  /// error that must be noticed (30 %).
  static constexpr Real kLateLimit_s = Real(0.036);
  static constexpr Real kGainLimit = Real(0.2);
  static constexpr Real kSigmas = Real(3);
  static constexpr Real kEnoughSwing = Real(3);  ///< times the floor: below, the loop reacts to wander (ResponseFit)

  /// @param expected_rms  floor: residual of the identified axis on the validation part, unit of the axis, > 0
  AxisResidual(const model::StickAxis& axis, Real expected_rms, Real sample_period_s);

  /// One tick. Sticks as they were sent, counts from neutral; `measured` in the unit of the axis.
  void update(Real stick_counts, Real other_counts, Real measured);
  /// No measurement in this tick, or a stick that is not ours: discards the block; a new one starts after 11 samples.
  void interrupt();
  const ResidualReport<Real>& report() const { return report_; }

 private:
  void process(std::size_t slot);
  void begin_block();
  void end_block();
  Real delayed_command() const;

  Real delay_s_;
  Real lead_zero_s_;
  Real expected_rms_;
  Real sample_period_s_;
  model::StickLaw<Real> law_;
  AxisDynamics<Real> dynamics_;
  std::array<Real, 2 * kHalfWindow + 1> measured_{};  ///< ring of the newest samples
  std::array<Real, 2 * kHalfWindow + 1> commands_{};  ///< static law of the same samples
  std::array<Real, kDelay> past_commands_{};          ///< ring of the commands up to the processed sample
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
  std::size_t past_newest_ = 0;
  std::uint32_t sample_ = 0;
  std::size_t in_block_ = 0;
  Real before_ = Real(0);
  Real sum_ = Real(0);
  Real predicted_ = Real(0);  ///< in the sample before
  bool running_ = false;
  ResponseFit<Real> fit_;
  ResidualReport<Real> report_;
};

/// The four stick axes side by side.
enum class MonitoredAxis : std::uint8_t { kRoll, kPitch, kYawRate, kClimb };
inline constexpr std::size_t kMonitoredAxes = 4;

template <typename Real>
class ResidualMonitor {
 public:
  /// Expected residual of each channel, in its unit; the defaults are twice the floor of the measured flights.
  struct Expected {
    Real roll_rad = Real(0.008);
    Real pitch_rad = Real(0.006);
    Real yaw_rate_rad_s = Real(0.05);
    Real climb_m_s = Real(0.07);
  };
  /// @param line_s  from the tick that sends a stick to the autopilot, plus from the measured attitude to the tick that
  ///        reads it: the delay that the vehicle file's (autopilot's stick to attitude) does not include.
  ResidualMonitor(const model::Vehicle& vehicle, const Expected& expected, Real sample_period_s, Real line_s);

  /// Sticks as sent, in counts from their balancing point: neutral plus the trim, as far as it is known.
  struct Sample {
    std::array<Real, kMonitoredAxes> stick_counts{};
    std::array<Real, kMonitoredAxes> measured{};
  };
  void update(const Sample& sample);
  void interrupt();
  const ResidualReport<Real>& report(MonitoredAxis channel) const {
    return channels_[static_cast<std::size_t>(channel)].report();
  }
  /// The channel whose last block has the largest ratio to its expected residual.
  MonitoredAxis worst() const;
  /// Whether any channel has departed from its model.
  bool departed() const;

 private:
  std::array<AxisResidual<Real>, kMonitoredAxes> channels_;
};

}  // namespace m100::sysid
