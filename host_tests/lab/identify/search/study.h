// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/search/selection.h"

namespace m100::lab::identify {

// From a request to its answer, for the stick axes and for translation alike: choose the effects, withdraw what the
// validation part does not confirm, look at what is left, give intervals, and derive the verdict.

/// What is shown of one direction of motion, one value for each sample of training and validation part together.
struct Trace {
  std::string suffix;         ///< of the series' names: "", or "_x", ...
  std::vector<double> input;  ///< the stick or command; of translation the acceleration that the tilted thrust gives
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
  bool about_mean = false;  ///< the mean of the residual is taken off before its autocorrelation
};

/// What one kind of motion contributes: its models, its errors, and the questions that only it can ask.
class Study {
 public:
  Study() = default;
  Study(const Study&) = delete;
  Study& operator=(const Study&) = delete;
  virtual ~Study() = default;

  virtual const Family& family() const = 0;
  /// The log's validation part predicted by the fit: root mean square error in the unit of the axis.
  virtual double validation_rmse(const Fit& fit) const = 0;
  /// The same error, block by block and sample by sample, for the comparison with the training part.
  virtual std::vector<std::vector<double>> validation_errors(const Fit& fit) const = 0;
  /// Takes from errors of the training and of the validation part, both block by block, what may be owed to an input
  /// that is not known between the rows of its log: sizes only, never beyond nought.
  virtual void keep_what_is_known(const Fit&, std::vector<std::vector<double>>&,
                                  std::vector<std::vector<double>>&) const {}
  /// Samples of a block in which the state shows that it was started from; none where a model has no memory.
  virtual std::size_t start_samples() const { return 0; }
  /// All of the fit's results but its parameters. Both parts of the log have at least one block.
  virtual ModelResult errors_of(const Fit& fit) const = 0;

  /// A reported number and the effect that it belongs to; empty: to the base model.
  struct Parameter {
    std::string effect;
    NamedValue value;
  };
  /// In the order of the structure; as many for every fit of the same structure.
  virtual std::vector<Parameter> parameters(const Fit& fit) const = 0;
  /// The numbers whose spread the jackknife looks at: one for each of parameters(), in which that one is monotone.
  virtual std::vector<double> coordinates(const Fit& fit) const = 0;
  /// The reported number `parameter` of the fit if its coordinate were `coordinate`.
  virtual double reported(const Fit& fit, std::size_t parameter, double coordinate) const = 0;

  /// What may still be predicted, and other doubts, after the selection: fills unexplained and noise_floor of the
  /// result, and adds findings.
  virtual void examine(const Selection& selection, IdentifyResult& result) const = 0;
  /// Whether what was named is likelier the shadow of what is still unexplained than a finding of its own.
  virtual bool shadow_only(const Selection& selection, const IdentifyResult& result) const = 0;
  /// Findings about the log and the effects, once all else of the result is there.
  virtual void annotate(const Selection& selection, IdentifyResult& result) const = 0;
  virtual Traces traces(const Fit& declared, const Fit& final_fit) const = 0;
};

/// Selects effects and withdraws those that the validation part does not confirm.
/// Preconditions: the request's declared structure is one of the study's family (see check_declared); options as for
/// select(). Cost: of select().
Selection choose(const Study& study, const Request& request, SelectionOptions options);

/// What was found about a log before and beside the selection.
struct Beside {
  std::vector<Finding> findings;
  std::vector<Change> changes;
  std::vector<std::string> unexplained;
};

/// Tests what is left, gives intervals and the verdict (verdict.h). Precondition: the selection is of this study.
/// Cost: one warm fit for each group of blocks left out, and the residual test.
IdentifyResult conclude(const Study& study, const Request& request, Selection selection, Beside beside);

/// @throws InputError unless the first declared name is one of `bases` and every other one is an effect that `knows`
///   accepts; `what` names the kind of motion in the message.
void check_declared(const std::vector<std::string>& declared, std::span<const std::string_view> bases,
                    bool (*knows)(const std::string& name), const char* what);

/// @throws InputError unless the training part has at least four blocks and the validation part at least one.
void check_blocks(std::size_t training, const std::string& training_file, std::size_t validation,
                  const std::string& validation_file);

}  // namespace m100::lab::identify
