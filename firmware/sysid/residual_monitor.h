// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/model/vehicle.h"
#include "firmware/sysid/axis_dynamics.h"
#include "firmware/sysid/response_fit.h"

namespace m100::sysid {

/// What a channel's residual says. It names no cause: that takes the whole log and a host.
template <typename Real>
struct ResidualReport {
  Real block_rms = Real(0);        ///< of the last complete block, unit of the axis
  Real ratio = Real(0);            ///< of its end, about its mean: over what may be expected of a right model
  std::uint32_t blocks = 0;        ///< complete blocks so far
  std::uint32_t blocks_over = 0;   ///< of them over the limit, in a row, up to now
  ResponseError<Real> response;    ///< gain and time over the last three blocks
  bool response_departed = false;  ///< the stick moved enough to say that gain or time are others than the model's
  bool departed = false;           ///< reality has left the model: by the response, by two blocks over, by one far over
};

/// The residual of `m100-lab identify`, in flight: simulation error over blocks of 2.5 s, each started from the
/// measured state (quadratic through eleven samples), of one stick axis. Works five samples behind, because the
/// quadratic is centred. Memory: fixed, about 1.6 kB for Real = double. Cost per sample: one static law and one step,
/// some 80 flops; at a block's start and end 100 more.
///
/// What may be expected of a right model at a block's end: the floor of the identified axis, the prediction's slope
/// times kTiming_s (of a line whose clocks are not ours) and its swing times kGain (half of an identified interval).
/// Offsets are left to est::TrimWatch: squares count about their mean in the block.
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
  /// The response has departed beyond these and three standard errors. Time: what a healthy aircraft may be late by. A
  /// tired battery takes 12 % of a loop's frequency, a load of 0.4 kg another 6 %; 2 zeta / w is then longer by 33 ms.
  /// (60 ms must be noticed.) Gain: midway between what an identified one may be off (10 %) and what must be noticed
  /// (30 %).
  static constexpr Real kLateLimit_s = Real(0.036);
  static constexpr Real kGainLimit = Real(0.2);
  static constexpr Real kSigmas = Real(3);
  static constexpr Real kEnoughSwing = Real(3);  ///< times the floor: below, the loop answers the wander (ResponseFit)

  /// @param expected_rms  floor: residual of the identified axis on the validation part, unit of the axis, > 0
  AxisResidual(const model::StickAxis& axis, Real expected_rms, Real sample_period_s);

  /// One tick. Sticks as they were sent, counts from neutral; `measured` in the unit of the axis.
  void update(Real stick_counts, Real other_counts, Real measured);
  /// No measurement in this tick, or a stick that is not ours: the block is thrown away, a new one starts when eleven
  /// samples have come.
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
  Real predicted_ = Real(0);  ///< of the sample before
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
  /// Expected residuals per channel, in its unit; the defaults are twice the floor of the measured flights.
  struct Expected {
    Real roll_rad = Real(0.008);
    Real pitch_rad = Real(0.006);
    Real yaw_rate_rad_s = Real(0.05);
    Real climb_m_s = Real(0.07);
  };
  /// @param line_s  from the tick that sends a stick to the autopilot, and from the measured attitude to the tick that
  ///        reads it: what a delay of the vehicle file (autopilot's stick to attitude) does not hold.
  ResidualMonitor(const model::Vehicle& vehicle, const Expected& expected, Real sample_period_s, Real line_s);

  /// Sticks as sent, counts from where they balance: neutral, and the trim as far as it is known.
  struct Sample {
    std::array<Real, kMonitoredAxes> stick_counts{};
    std::array<Real, kMonitoredAxes> measured{};
  };
  void update(const Sample& sample);
  void interrupt();
  const ResidualReport<Real>& report(MonitoredAxis channel) const {
    return channels_[static_cast<std::size_t>(channel)].report();
  }
  /// The channel whose last block lies farthest above what is expected.
  MonitoredAxis worst() const;
  /// Whether any channel has departed from its model.
  bool departed() const;

 private:
  std::array<AxisResidual<Real>, kMonitoredAxes> channels_;
};

}  // namespace m100::sysid
