// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/whitening.h"

namespace m100::lab::identify {

/// One stick axis simulated from gap to gap without restarts, and compared with the log. Both are averaged over 50 ms,
/// or over the time between two logged rows if that is longer. Long runs show what blocks of 2.5 s hide: clocks that
/// disagree by 0.01 s, and a vehicle that changes.
class FreeRun {
 public:
  static constexpr double kMinMean_s = 0.05;
  static constexpr double kSettle_s = 1.0;  ///< a free run forgets its start within this time

  /// Ranges may overlap or touch: they are joined. The data must outlive the run.
  FreeRun(const AxisData& data, const std::vector<Range>& ranges);

  const AxisData& data() const { return data_; }
  std::size_t size() const { return time_s_.size(); }  ///< rows, one for each mean
  const std::vector<double>& time_s() const { return time_s_; }
  const std::vector<Segment>& segments() const { return segments_; }
  /// Sets the weights of the innovations. @param weights  one for each row; empty: equal weights
  void set_weights(Rows weights) { weights_ = std::move(weights); }
  const Rows& weights() const { return weights_; }
  /// Replaces rows by their weighted innovations under an autoregression.
  void whiten_rows(const Ar& filter, Eigen::Ref<Rows> values) const;
  /// n ln(mean square of the weighted innovations of an error under its own autoregression).
  double score(const Rows& error) const;
  std::size_t mean() const { return mean_; }  ///< samples in a row
  double mean_s() const { return static_cast<double>(mean_) * data_.period_s; }
  double seconds() const { return static_cast<double>(size()) * mean_s(); }

  /// Simulated minus measured. A transport delay below zero takes the stick from the future.
  Rows error(const model::StickAxis& axis) const { return error(axis, axis, 1e300); }
  /// Simulated minus measured for a vehicle that changes from `before` to `after` at `switch_s` on the log's clock.
  Rows error(const model::StickAxis& before, const model::StickAxis& after, double switch_s) const;

 private:
  struct Run {
    std::size_t begin;  ///< first sample, which gives the measured initial state
    std::size_t end;
    double value;
    double rate_per_s;
  };
  /// Writes the commands of run `number` after the delay, for a vehicle that changes at `switch_s`.
  /// @returns the first sample after the change; without a change in this run, its end
  std::size_t arrive(const model::StickAxis& before, const model::StickAxis& after, double switch_s, std::size_t number,
                     std::vector<double>& out) const;

  const AxisData& data_;
  std::size_t mean_;    ///< samples in a mean
  std::size_t settle_;  ///< samples
  std::vector<Run> runs_;
  std::vector<double> time_s_;
  std::vector<Segment> segments_;
  Rows weights_;
  StickCommands commands_{false};  ///< of the runs
};

/// One free parameter of a whitened fit.
struct FreeParameter {
  std::string name;
  double model::StickAxis::*member = nullptr;
  double step = 0.0;  ///< of the derivative, in the member's unit
  double low = 0.0;
  double high = 0.0;
};

/// Result of a maximum-likelihood fit to free runs. The fit models the residual as an autoregression of order 4.
struct WhitenedFit {
  model::StickAxis before;
  model::StickAxis after;
  double offset = 0.0;         ///< constant part of simulated minus measured, which was removed
  double score = 0.0;          ///< n ln(mean square of the innovations)
  std::vector<double> values;  ///< of the free parameters, then the size of the change if there is one
  std::vector<double> sigmas;  ///< their standard errors
};

/// A change of the axis: `free_parameter` jumps by a free amount at `at_s`.
struct ParameterJump {
  FreeParameter free_parameter;
  double at_s = 0.0;
  double size = 0.0;  ///< at which the fit starts
};

/// Gauss-Newton from `start`. Free are the parameters given, a constant offset of the response and the size of
/// `change`. Cost: at most ten iterations, each with one simulation per free parameter and one to five trial steps.
WhitenedFit fit_whitened(const FreeRun& run, const model::StickAxis& start,
                         std::span<const FreeParameter> free_parameters, const ParameterJump* change = nullptr);
/// Repeats the fit until its score stops improving: parameters that compensate each other converge slowly.
WhitenedFit fit_to_convergence(const FreeRun& run, const model::StickAxis& start,
                               std::span<const FreeParameter> free_parameters);

}  // namespace m100::lab::identify
