// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "host_tests/lab/identify/model/translation/flight_winds.h"
#include "host_tests/lab/identify/model/translation/translation_data_set.h"
#include "host_tests/lab/identify/model/translation/translation_family.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/selection/problem.h"

namespace m100::lab::identify::translation {

/// Translation of a request: its models, its errors, its own tests. The request must outlive it.
class TranslationProblem final : public Problem {
 public:
  /// @param own_winds  each flight of the training log has its own wind
  TranslationProblem(const Request& request, bool own_winds);
  const Family& family() const override { return family_; }

  double validation_rmse(const Fit& fit) const override;
  std::vector<std::vector<double>> validation_errors(const Fit& fit) const override;
  ModelResult errors_of(const Fit& fit) const override;
  std::vector<Parameter> parameters(const Fit& fit) const override;
  std::vector<double> coordinates(const Fit& fit) const override;

  /// `coordinate` limited to the physical range of the parameter, unless the fit itself lies outside of that range.
  double reported(const Fit& fit, std::size_t parameter, double coordinate) const override;

  /// The winds of the flights of the training log, relative to their mean.
  std::vector<FlightWind> winds(const Fit& fit) const { return flight_winds(training_, fit); }

  /// A force that grows with the distance from a place (translation_change_point.h).
  std::vector<Finding> tether(const Fit& fit) const;

  /// The changes in flight; empty: none was found. Both parts are searched if they are of one log.
  std::vector<Change> changes(const Fit& fit) const;
  void examine(const Selection& selection, IdentifyResult& result) const override;
  bool are_side_effects(const Selection& selection, const IdentifyResult& result) const override;
  void annotate(const Selection& selection, IdentifyResult& result) const override;
  Traces traces(const Fit& declared, const Fit& final_fit) const override;

 private:
  void check_heads() const;

  /// Whether the selected effects remove less than a quarter of the squared error of the declared model.
  static bool weak(const Selection& selection);

  /// Whether a periodic force was named although the residual still oscillates.
  static bool still_oscillates(const std::vector<SelectionStep>& steps, const IdentifyResult& result);

  /// Adds a note where a periodic force was rejected because the vehicle itself moves with that period.
  static void add_motion_note(IdentifyResult& result);
  /// Adds to not_separable the effects that these data cannot distinguish: at constant heading a wind, a force fixed to
  /// the body and a trim of the sticks look the same.
  void add_indistinguishable(const std::vector<SelectionStep>& steps, IdentifyResult& result) const;

  const Request& request_;
  ThrustSource thrust_;
  TranslationDataSet training_;
  TranslationDataSet validation_;
  TranslationFamily family_;
};

}  // namespace m100::lab::identify::translation
