// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/selection/selection.h"

namespace m100::lab::identify {

// From a request to its result, the same for the stick axes and for translation: select the effects, withdraw those
// that the validation part does not confirm, test the residual, compute intervals, and derive the verdict.

/// The series of one direction of motion: one value for each sample of the training blocks, then of the validation's.
struct Trace {
  std::string suffix;         ///< of the series' names: "", or "_x", ...
  std::vector<double> input;  ///< the stick or command; for translation the acceleration of the tilted thrust
  std::vector<double> measured;
  std::vector<double> declared;
  std::vector<double> final_model;
};

struct Traces {
  std::vector<double> t_s;
  std::vector<char> validation;
  std::vector<Trace> directions;  ///< all as long as t_s
  double sample_period_s = 0.01;
  std::size_t lag_step = 1;  ///< of the autocorrelations, in samples
  double longest_lag_s = 2.0;
  bool about_mean = false;  ///< the mean of the residual is subtracted before its autocorrelation
};

/// The part of an identification that depends on the kind of motion: its models, its errors, and its own tests.
class Problem {
 public:
  Problem() = default;
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;
  virtual ~Problem() = default;

  virtual const Family& family() const = 0;
  /// Root mean square prediction error of the fit on the validation part, in the unit of the axis.
  virtual double validation_rmse(const Fit& fit) const = 0;
  /// Errors of the fit on the validation part, block by block and sample by sample, to compare with the training part.
  virtual std::vector<std::vector<double>> validation_errors(const Fit& fit) const = 0;
  /// Reduces the errors of training and validation part, both block by block, by the part that an undersampled input
  /// may have caused. Signs stay; no error is reduced beyond zero.
  virtual void subtract_input_uncertainty(const Fit&, std::vector<std::vector<double>>&,
                                          std::vector<std::vector<double>>&) const {}
  /// Samples at the start of a block that depend on its initial state; none where a model has no memory.
  virtual std::size_t start_samples() const { return 0; }
  /// Whether the rows of the log determine the initial states of blocks. If not, errors at the starts are no evidence.
  virtual bool are_starts_measured() const { return true; }
  /// All results of the fit except its structure and parameters. Precondition: both parts have at least one block.
  virtual ModelResult errors_of(const Fit& fit) const = 0;

  /// A reported number and the effect to which it belongs; empty: the base model.
  struct Parameter {
    std::string effect;
    NamedValue value;
  };
  /// The reported parameters in the order of the structure; the same count for every fit of one structure.
  virtual std::vector<Parameter> parameters(const Fit& fit) const = 0;
  /// The numbers whose spread the jackknife estimates, one for each of parameters(); the parameter is monotone in it.
  virtual std::vector<double> coordinates(const Fit& fit) const = 0;
  /// The reported number `parameter` of the fit if its coordinate were `coordinate`.
  virtual double reported(const Fit& fit, std::size_t parameter, double coordinate) const = 0;

  /// Tests the residual after the selection, and other grounds for doubt: fills unexplained and noise_floor of the
  /// result, and adds findings.
  virtual void examine(const Selection& selection, IdentifyResult& result) const = 0;
  /// Whether the named effects are probably side effects of the unexplained cause and not findings of their own.
  virtual bool are_side_effects(const Selection& selection, const IdentifyResult& result) const = 0;
  /// Adds findings about the log and the effects, once models, intervals and effects are complete.
  virtual void annotate(const Selection& selection, IdentifyResult& result) const = 0;
  virtual Traces traces(const Fit& declared, const Fit& final_fit) const = 0;
};

/// Selects effects and withdraws those that the validation part does not confirm. Preconditions: the request's declared
/// structure is one of the problem's family (see check_declared); options as for select(). Cost: that of select().
Selection select_effects(const Problem& problem, const Request& request, SelectionOptions options);

/// Removes the effect's name from the result. The model keeps the effect.
void withdraw(Selection& selection, const std::string& name);

/// Results about a log that do not come from the selection.
struct SideFindings {
  std::vector<Finding> findings;
  std::vector<Change> changes;
  std::vector<std::string> unexplained;
  std::vector<RemainderCurve> remainder;
};

/// Tests the residual, computes the intervals and the verdict (verdict.h). Precondition: the selection is of this
/// problem. Cost: one warm fit for each group of blocks left out and for each effect, and at most two residual tests.
IdentifyResult conclude(const Problem& problem, const Request& request, Selection selection,
                        SideFindings side_findings);

/// The end of a message about an unknown effect: the most similar known name (companion::did_you_mean()), or nothing.
std::string effect_meant(std::string_view word);

/// @throws InputError unless the first declared name is one of `bases`, and every other one is an effect that
///   `supports` accepts and is declared once; `what` names the kind of motion in the message.
void check_declared(const std::vector<std::string>& declared, std::span<const std::string_view> bases,
                    bool (*supports)(const std::string& name), const char* what);

/// @throws InputError unless the training part has at least four blocks and the validation part at least one.
void check_blocks(std::size_t training, const std::string& training_file, std::size_t validation,
                  const std::string& validation_file);

}  // namespace m100::lab::identify
