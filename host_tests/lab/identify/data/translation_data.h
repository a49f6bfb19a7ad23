// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "firmware/model/translation_effect.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Source of the rigid body's thrust.
enum class ThrustSource {
  kSetPoint,  ///< the log's thrust_ratio
  kVertical,  ///< the accelerometer's body z; without one, the thrust that the vertical acceleration needs
  kWeight,    ///< weight over the cosine of the tilt, as a height loop keeps it
  kTangents   ///< roll and pitch separately, g tan(pitch) forward and -g tan(roll) to the left: as in the paper
};

/// The part of an external force u that the residual shows. A measured thrust already contains a component of u, which
/// is then missing in the residual.
enum class ForceProjection {
  kWholeForce,    ///< u: the thrust has another source
  kAcrossThrust,  ///< u - (u . b3) b3: the thrust was taken from the accelerometer's body z
  kOffVertical,   ///< u - u_z / b3_z b3: the thrust was taken from the vertical acceleration
};

/// The signals of a log for translation, at the log's own rate. World frame, z up.
///
/// Rigid body: a = T b3 - g e3, where b3 is the body's z axis and T the thrust over mass. T is the logged thrust set
/// point times g; without one, see ThrustSource. The vertical axis is used only with a set point, because otherwise the
/// thrust is measured and not predicted.
///
/// a comes from velocity; without it from position; without both from the accelerometer. Every predicted acceleration
/// passes the filter that the measured a has passed: the slope of a least-squares line through 0.2 s of the velocity.
/// It is applied twice if a comes from position. A logged velocity adds its own mean over velocity_mean_s.
struct TranslationData {
  /// @throws InputError naming file and signal: the log has no attitude or thrust direction, or no signal of motion.
  /// Precondition: with ThrustSource::kSetPoint the log has thrust_ratio, with kTangents roll and pitch.
  TranslationData(const logs::FlightLog& log, ThrustSource thrust_from);

  /// The filtered value of an acceleration at sample i. Preconditions: `acceleration` has one value per sample of the
  /// log; i and the `margin` samples on either side of it are inside the log.
  double filtered(const std::vector<double>& acceleration, std::size_t i) const;
  double time_s(std::size_t i) const { return start_s + period_s * static_cast<double>(i); }
  /// Number of the flight in which a sample lies.
  std::size_t flight_of(std::size_t i) const;
  /// Whether the log has the signals in which an effect with these needs shows.
  bool has_signals_for(const model::Needs& needs) const {
    return (!needs.velocity || has_velocity) && (!needs.thrust_set_point || has_thrust) &&
           (!needs.tilt_in_thrust || source != "force");
  }
  bool usable(std::size_t i) const { return i >= margin && i + margin < valid.size() && valid[i] != 0; }

  double start_s = 0.0;
  double period_s = 0.01;
  std::size_t axes = 2;     ///< 3 with a thrust set point
  bool has_thrust = false;  ///< T is a set point, so gain and lag of thrust can be found
  ForceProjection projection =
      ForceProjection::kWholeForce;              ///< how much of an outer force the difference to the rigid body shows
  bool has_velocity = false;                     ///< logged, or the slope of position: drag can be found
  bool winds_per_flight = false;                 ///< each flight has its own wind (flight_winds.h)
  std::vector<std::size_t> flights{0};           ///< first samples of the logs that were joined; a single log: 0
  bool has_yaw = false;                          ///< yaw is logged: forces fixed to body and world differ
  std::string source;                            ///< of a: "velocity", "position" or "force"
  std::array<std::vector<double>, 3> measured;   ///< a, filtered [m/s^2]
  std::array<std::vector<double>, 3> direction;  ///< b3
  std::vector<double> thrust;                    ///< T [m/s^2]
  std::array<std::vector<double>, 3> velocity;   ///< [m/s]
  std::vector<double> heading_cosine;            ///< of the yaw angle; 1 where yaw is not logged
  std::vector<double> heading_sine;
  std::vector<char> valid;      ///< 0 on the ground and a second after it, and where the filter would reach into a gap
  std::vector<double> weights;  ///< of the filter, 2 margin + 1
  std::size_t margin = 0;
};

/// Ranges of a log divided into blocks of 2.5 s and thinned to 25 Hz, for fits and errors. Rows are ordered by block,
/// then by axis, then by sample.
struct TranslationBlocks {
  /// The data must outlive the blocks. Ranges may extend beyond the log's ends. Pieces with usable samples for less
  /// than half a block are left out, so that there may be no block at all.
  /// @param head_s  length [s] of the start of each flight's ranges, which goes into `head` and not here; 0: no head
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
  std::shared_ptr<const TranslationBlocks> head;  ///< the blocks that give each flight's wind; null: none
};

inline constexpr double kStandardGravity_m_s2 = 9.80665;

}  // namespace m100::lab::identify
