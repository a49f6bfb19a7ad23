// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/search/family.h"
#include "host_tests/lab/identify/translation/translation_part.h"
#include "host_tests/lab/identify/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Constant accelerations in the world by which flights differ: one column (x, y) [m/s^2] for each flight.
using Winds = Eigen::Matrix<double, 2, Eigen::Dynamic>;

/// The wind of each flight of a part, where the part says that flights have winds of their own. What a wind does to the
/// vehicle at rest is a constant acceleration; all else of the model is shared.
///
/// There are two kinds. *Of several logs* (TranslationData::winds_per_flight): least squares over the blocks of each
/// flight, about the mean of all flights, which stays the steady_wind of the model. *From the first seconds*
/// (TranslationBlocks::head): least squares over the head of each flight, which no error is counted in; the whole wind,
/// so that the model has none.
///
/// Both are linear in what they explain. Taken from the target and from every column of a regression, they are fitted
/// jointly with it, exactly and without a search.
class FlightWinds {
 public:
  /// The part must outlive it. Cost: that of two columns, where it is active.
  explicit FlightWinds(const TranslationBlocks& part);

  bool active() const { return own_ || head_; }
  /// Of values in the part's rows. @param head  the same in the rows of the part's head, where there is one.
  /// @param weights  one for each block; empty: all count once. A flight that has no block has the mean.
  Winds of(const Vector& rows, const Vector& head, std::span<const int> weights) const;
  void take(const Winds& winds, Vector& rows) const;
  /// What of() and take() do to each column of a regression and to its target.
  void take_from(Matrix& columns, const Matrix& head_columns, Vector& target, const Vector& head_target,
                 std::span<const int> weights) const;

 private:
  const TranslationBlocks& part_;
  bool own_;   ///< of several logs
  bool head_;  ///< from the first seconds
  Matrix columns_;
  Matrix head_columns_;
};

/// The winds of a fit, flight by flight, as its parameters hold them behind the linear ones. Empty: it has none.
Winds winds_in(const Fit& fit);

/// By how much a flight's wind differs from the mean of all flights, with its standard error over blocks [m/s^2].
struct FlightWind {
  std::array<double, 2> accel_m_s2{};
  std::array<double, 2> sigma_m_s2{};
  bool known = false;  ///< the flight has at least two blocks
};
/// Asked of what the fit leaves of a part of several logs that has no winds of its own yet, or has them.
std::vector<FlightWind> flight_winds(const Part& part, const Fit& fit);
/// Whether any of them is worth a number: larger than the least steady_wind, and than four standard errors.
bool differ(const std::vector<FlightWind>& winds);
/// "each flight has a wind of its own, about the mean of all: log 1 (+0.21, -0.03) +-0.02 m/s^2, ..."
std::string in_words(const std::vector<FlightWind>& winds);

/// Number (from 1) of the first flight whose head has no block that can be used though the flight has others; 0: none.
/// Precondition: the part has a head.
std::size_t flight_without_head(const TranslationBlocks& part);

/// The wind that each flight of a part begins with, a sentence. Precondition: the part has a head.
std::string first_winds_in_words(const Part& part, const Fit& fit, double head_s);

}  // namespace m100::lab::identify::translation
