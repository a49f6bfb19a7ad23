// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"
#include "host_tests/lab/identify/selection/problem.h"

namespace m100::lab::identify {

/// One stick axis of a request: its models, its errors, its own tests.
class AxisProblem final : public Problem {
 public:
  /// @param flight_trims  the trim of each flight of a joined log, subtracted from its stick; empty: none
  explicit AxisProblem(const Request& request, const StickClock& clock = {},
                       const std::vector<double>& flight_trims = {});
  /// The problem with training and validation part exchanged. Precondition: both are of one log. @throws InputError if
  /// the validation part is too short, or its stick does not move.
  std::unique_ptr<AxisProblem> exchanged() const {
    Request request = request_;
    std::swap(request.train, request.validate);
    return std::unique_ptr<AxisProblem>(new AxisProblem(std::move(request), *this));
  }
  const Family& family() const override { return *family_; }
  const AxisFamily& axis_family() const { return *family_; }
  const AxisDataSet& training() const { return training_; }
  const AxisDataSet& validation() const { return validation_; }
  const Request& request() const { return request_; }
  const std::string& stick_name() const { return training_.signals.stick_name; }
  /// Ranges of the training part, and of the validation part where it is in the same log.
  std::vector<Range> free_ranges() const;
  /// free_ranges() of the training log, simulated without restarts.
  FreeRun free_run() const { return free_run(training_.signals.data); }
  /// free_ranges() simulated without restarts from `data`, another interpretation of the training log, which must
  /// outlive the run.
  FreeRun free_run(const AxisData& data) const;
  double validation_rmse(const Fit& fit) const override { return validation_.blocks.rmse(family_->model(fit)); }
  std::vector<std::vector<double>> validation_errors(const Fit& fit) const override;
  void subtract_input_uncertainty(const Fit& fit, std::vector<std::vector<double>>& training,
                                  std::vector<std::vector<double>>& validation) const override;
  std::size_t start_samples() const override {
    return static_cast<std::size_t>(std::lround(FreeRun::kSettle_s / training_.signals.data.period_s));
  }
  bool are_starts_measured() const override;
  ModelResult errors_of(const Fit& fit) const override;
  std::vector<Parameter> parameters(const Fit& fit) const override;
  std::vector<double> coordinates(const Fit& fit) const override { return fit.parameters; }
  double reported(const Fit& fit, std::size_t parameter, double coordinate) const override;
  void examine(const Selection& selection, IdentifyResult& result) const override;
  bool are_side_effects(const Selection&, const IdentifyResult&) const override { return false; }
  void annotate(const Selection&, IdentifyResult& result) const override;
  Traces traces(const Fit& declared, const Fit& final_fit) const override;

 private:
  /// Other parts of the same log. @throws InputError
  AxisProblem(Request request, const AxisProblem& same_log)
      : request_(std::move(request)),
        training_(same_log.training_, request_.train),
        validation_(training_, request_.validate) {
    check_and_make_family();
  }
  void check_and_make_family();
  /// Adds reasons for doubt that no regression finds, such as a poor fit, a wrong unit or swapped columns.
  void add_doubts(const Selection& selection, IdentifyResult& result) const;
  /// Adds a note if unknown motion of the stick between two rows may cause a tenth of the residual power.
  void undersampled(const model::StickAxis& model, IdentifyResult& result) const;
  /// Whether the response follows the other stick and not its own. Precondition: the other stick was logged.
  bool follows_other_stick() const;
  /// Adds findings about wrong signs and units of the column map, from the gain [unit per count or per command].
  void misreadings(const model::StickAxis& model, IdentifyResult& result) const;
  Request request_;
  AxisDataSet training_;
  AxisDataSet validation_;
  std::optional<AxisFamily> family_;  ///< made once the request has been checked
};

}  // namespace m100::lab::identify
