// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/translation_data_set.h"
#include "host_tests/lab/identify/model/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Winds of flights as constant accelerations in the world: one column (x, y) [m/s^2] for each flight.
using Winds = Eigen::Matrix<double, 2, Eigen::Dynamic>;

/// A wind for each flight of a part: the constant acceleration [m/s^2] that the wind gives to the vehicle at rest. The
/// flights share the rest of the model.
///
/// With TranslationData::winds_per_flight each wind is fitted to the blocks of its flight, as a deviation from the mean
/// of all flights; that mean is the steady_wind of the model. With a head (TranslationBlocks::head) it is fitted to the
/// first seconds of its flight, in which no error is counted; the model then has no steady_wind.
///
/// The winds are linear parameters. They are eliminated from a regression by subtracting their least-squares fit from
/// its target and from each of its columns.
class FlightWinds {
 public:
  /// `part` must outlive this object. Cost: that of two columns of a regression, if active().
  explicit FlightWinds(const TranslationBlocks& part);

  bool active() const { return own_ || head_; }
  /// Estimates the winds in a series by least squares; without a head, as deviations from their mean. A flight without
  /// a block gets 0. @param rows  the series in the rows of the part, used without a head
  /// @param head  the series in the rows of the part's head, used if there is one
  /// @param weights  one for each block of the part, unused with a head; empty: all 1
  Winds of(const Vector& rows, const Vector& head, std::span<const int> weights) const;
  void take(const Winds& winds, Vector& rows) const;
  /// Estimates the winds of each column of a regression and of its target, and subtracts them.
  void take_from(Matrix& columns, const Matrix& head_columns, Vector& target, const Vector& head_target,
                 std::span<const int> weights) const;

 private:
  const TranslationBlocks& part_;
  bool own_;   ///< of several logs
  bool head_;  ///< from the first seconds
  Matrix columns_;
  Matrix head_columns_;
};

/// The winds of a fit, flight by flight, which follow the linear parameters. Empty: it has none.
Winds winds_in(const Fit& fit);

/// Deviation of a flight's wind from the mean of all flights, with its standard error over blocks [m/s^2].
struct FlightWind {
  std::array<double, 2> accel_m_s2{};
  std::array<double, 2> sigma_m_s2{};
  bool known = false;  ///< the flight has at least two blocks
};
/// Estimates the winds in a part of several logs, from the residual of a fit and the winds that the fit already has.
std::vector<FlightWind> flight_winds(const TranslationDataSet& part, const Fit& fit);
/// Whether any wind is larger than the smallest relevant steady_wind and than four standard errors.
bool are_distinct(const std::vector<FlightWind>& winds);
/// The winds in one sentence for the report.
std::string describe(const std::vector<FlightWind>& winds);

/// Number (from 1) of the first flight that has blocks, but none in its head; 0: there is no such flight.
/// Precondition: the part has a head.
std::size_t flight_without_head(const TranslationBlocks& part);

/// The wind at the start of each flight of a part, in one sentence. Precondition: the part has a head.
std::string describe_head_winds(const TranslationDataSet& part, const Fit& fit, double head_s);

}  // namespace m100::lab::identify::translation
