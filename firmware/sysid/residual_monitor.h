// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/model/vehicle.h"
#include "firmware/sysid/axis_dynamics.h"

namespace m100::sysid {

/// What a channel's residual says. It names no cause: that takes the whole log and a host.
template <typename Real>
struct ResidualReport {
  Real block_rms = Real(0);       ///< of the last complete block, unit of the axis
  Real ratio = Real(0);           ///< block_rms over the expected one
  std::uint32_t blocks = 0;       ///< complete blocks so far
  std::uint32_t blocks_over = 0;  ///< of them over the limit, in a row, up to now
  bool departed = false;  ///< reality has left the model: two blocks in a row over the limit, or one far over it
};

/// The residual of `m100-lab identify`, in flight: simulation error over blocks of 2.5 s, each started from the
/// measured state (quadratic through eleven samples), of one stick axis. Works five samples behind, because the
/// quadratic is centred. Memory: fixed, about 1.3 kB for Real = double. Cost per sample: one static law and one step,
/// some 60 flops; at a block's start 100 more.
template <typename Real>
class AxisResidual {
 public:
  static constexpr std::size_t kHalfWindow = 5;
  static constexpr std::size_t kBlock = 250;  ///< samples
  static constexpr std::size_t kDelay = 64;   ///< most samples of transport delay, plus one
  static constexpr Real kLimit = Real(3);     ///< times the expected residual: over
  static constexpr Real kFarLimit = Real(6);  ///< times the expected residual: departed at once

  /// @param expected_rms  residual of the identified axis on the validation part, unit of the axis, > 0
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
  bool running_ = false;
  ResidualReport<Real> report_;
};

/// The four stick axes side by side.
enum class Channel : std::uint8_t { kRoll, kPitch, kYawRate, kClimb };
inline constexpr std::size_t kChannels = 4;

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
  ResidualMonitor(const model::Vehicle& vehicle, const Expected& expected, Real sample_period_s);

  /// Sticks as sent, counts from neutral.
  struct Sample {
    std::array<Real, kChannels> stick_counts{};
    std::array<Real, kChannels> measured{};
  };
  void update(const Sample& sample);
  void interrupt();
  const ResidualReport<Real>& report(Channel channel) const {
    return channels_[static_cast<std::size_t>(channel)].report();
  }
  /// The channel whose last block lies farthest above what is expected.
  Channel worst() const;
  /// Whether any channel has departed from its model.
  bool departed() const;

 private:
  std::array<AxisResidual<Real>, kChannels> channels_;
};

}  // namespace m100::sysid
