// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Where the thrust of the rigid body comes from.
enum class Thrust {
  kSetPoint,  ///< the log's thrust_ratio
  kVertical,  ///< the accelerometer's body z, or what the vertical acceleration asks for: an ideal rotor
  kWeight,    ///< weight over the cosine of the tilt: a vehicle whose height loop hides its thrust from the horizontal
  kTangents  ///< the same with roll and pitch apart, g tan(pitch) forward and -g tan(roll) to the left: the paper's way
};

/// A thrust that is measured has taken in its share of every outer force u, and the residual lacks that share.
enum class Shown {
  kWhole,     ///< u: the thrust comes from elsewhere
  kAcross,    ///< u - (u . b3) b3: the accelerometer's body z is what the thrust was taken from
  kOffPlumb,  ///< u - u_z / b3_z b3: the vertical acceleration is
};

/// What a log says about translation, at the log's own rate. World frame, z up.
///
/// Rigid body: a = T b3 - g e3, where b3 is the body's z axis and T the thrust over mass. T is the logged thrust set
/// point times g; without one, see Thrust. Only with a set point is the vertical axis a test of the model: otherwise
/// thrust is not predicted but measured.
///
/// a comes from velocity, else position, else the accelerometer. Every series passes the same filter: the slope of a
/// least-squares line through 0.2 s of its integral (a parabolic weight on acceleration), so that measured and
/// predicted accelerations lose the same detail, and noise of the velocity is not differentiated twice.
struct TranslationData {
  /// @throws InputError naming file and signal where the log has no attitude, or nothing to take the motion from.
  /// Precondition: with Thrust::kSetPoint the log has thrust_ratio, with kTangents roll and pitch.
  TranslationData(const logs::FlightLog& log, Thrust thrust_from);

  /// The filtered value of an acceleration at sample i: one value per sample of the log, and margin <= i, i + margin
  /// inside of the log.
  double filtered(const std::vector<double>& acceleration, std::size_t i) const;
  double time_s(std::size_t i) const { return start_s + period_s * static_cast<double>(i); }
  /// Number of the flight in which a sample lies.
  std::size_t flight_of(std::size_t i) const;
  bool usable(std::size_t i) const { return i >= margin && i + margin < valid.size() && valid[i] != 0; }

  double start_s = 0.0;
  double period_s = 0.01;
  std::size_t axes = 2;                          ///< 3 with a thrust set point
  bool has_thrust = false;                       ///< T is a set point, and gain and lag of thrust mean something
  Shown shown = Shown::kWhole;                   ///< how much of an outer force the difference to the rigid body shows
  bool has_velocity = false;                     ///< drag means something
  bool winds_per_flight = false;                 ///< the flights have winds of their own (flight_winds.h)
  std::vector<std::size_t> flights{0};           ///< first samples of the logs that were joined; of a log alone: 0
  bool has_yaw = false;                          ///< body and world can be told apart
  std::string source;                            ///< of a: "velocity", "position" or "force"
  std::array<std::vector<double>, 3> measured;   ///< a, filtered [m/s^2]
  std::array<std::vector<double>, 3> direction;  ///< b3
  std::vector<double> thrust;                    ///< T [m/s^2]
  std::array<std::vector<double>, 3> velocity;   ///< [m/s]
  std::vector<double> heading_cosine;            ///< of the yaw angle; 1 where yaw is not logged
  std::vector<double> heading_sine;
  std::vector<char> valid;      ///< 0 where the filter would reach into a gap
  std::vector<double> weights;  ///< of the filter, 2 margin + 1
  std::size_t margin = 0;
};

/// Ranges of a log cut into blocks of 2.5 s, thinned to 25 Hz: what is fitted and judged. Rows run over blocks, in each
/// over axes, in each over samples.
struct TranslationBlocks {
  /// The data must outlive the blocks. Ranges may overlap the log's ends; what is shorter than half a block, or less
  /// than half usable, is left out, so that there may be no block at all.
  /// @param head_s  the first so many seconds of each flight in the ranges become `head` instead; 0: none
  TranslationBlocks(const TranslationData& data, const std::vector<Range>& ranges, double head_s = 0.0);

  struct Block {
    std::vector<std::size_t> samples;  ///< indices of the log
    std::size_t row = 0;               ///< of its first sample on the first axis
  };
  static constexpr double kBlock_s = 2.5;
  static constexpr double kRate_hz = 25.0;

  const TranslationData* data;
  std::vector<Block> blocks;
  std::size_t rows = 0;
  double sample_period_s = 0.04;
  std::shared_ptr<const TranslationBlocks> head;  ///< where each flight's wind is taken from; null: nowhere apart
};

inline constexpr double kStandardGravity_m_s2 = 9.80665;

}  // namespace m100::lab::identify
