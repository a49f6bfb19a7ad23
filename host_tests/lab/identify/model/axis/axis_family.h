// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/axis_scale.h"
#include "host_tests/lab/identify/selection/selection.h"

namespace m100::lab::identify {

/// The models of one stick axis: base "first_order" or "second_order", then effects of model::kAxisEffects.
class AxisFamily final : public Family {
 public:
  explicit AxisFamily(const AxisBlocks& training);

  std::size_t block_count() const override { return training_.size(); }
  std::size_t samples_in(std::size_t block) const override { return training_[block].end - training_[block].begin; }
  Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const override;
  Fit polish(const Fit& fit, std::span<const int> weights) const override;
  std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const override;
  std::vector<Edit> edits(const Structure& present) const override;
  Structure completed(const Structure& declared) const override;
  Structure without(const Structure& structure, const std::string& name) const override;
  /// All other parameters keep their values, unless the base model changes.
  Fit switched_off(const Fit& fit, const std::string& name) const override;
  bool is_significant(const Fit& fit, const std::string& name) const override;
  bool is_at_bound(const Fit& fit) const override { return !parameters_at_bound(fit).empty(); }
  /// The indices of the parameters at the edge of their physical range.
  std::vector<std::size_t> parameters_at_bound(const Fit& fit) const;
  /// If the fit has a dead zone: the same with a jump at its edge, or without that jump if it has one.
  std::vector<Fit> variants(const Fit& fit) const override;

  model::StickAxis model(const Fit& fit) const;
  /// Names of the free parameters in order, as the JSON spells them, each with its effect or base model.
  struct ParameterName {
    std::string effect;
    std::string name;
  };
  std::vector<ParameterName> parameter_names(const Structure& structure) const;
  /// A fit's parameter in its physical unit.
  double physical(const Fit& fit, std::size_t parameter) const;
  /// A fit of the same structure and shape with the parameters of `axis`, limited to their bounds.
  Fit with_parameters_of(Fit like, const model::StickAxis& axis) const;
  /// Starting points for a structure with one more effect: each start and variant of that effect. A start at which the
  /// effect would do nothing is replaced by the smallest significant size.
  std::vector<Fit> starts_with_effect(const Edit& edit, const Fit& known) const;
  const AxisScale& scale() const { return scale_; }
  double period_s() const { return training_.data().period_s; }
  double stick_row_s() const { return training_.data().stick_row_s; }

  static bool supports(const std::string& name);

 private:
  /// Starting points of a fit of `structure`: parameters known from `warm` are kept; every new effect starts from each
  /// of its starts and variants.
  static std::vector<Fit> starts_of(const Structure& structure, const Fit* warm);
  /// The best fit from several starts after a few iterations; of many starts only the best quarter after two iterations
  /// continues. A single start is returned without a fit. Precondition: there is at least one start.
  Fit best_of(std::vector<Fit> starts, std::span<const int> weights) const;
  bool is_parameter_significant(const Fit& fit, std::size_t parameter, const model::AxisNumber& number) const;
  std::size_t samples_of(std::span<const int> weights) const;
  Fit run(Fit start, std::span<const int> weights, int iterations) const;
  /// The fit with a jump at the dead zone's edge. The zone's width is found by a scan, because the error has no
  /// gradient: it changes only where the width passes a logged stick position.
  Fit with_jump(Fit fit, std::span<const int> weights) const;
  double sum_of_squares(const Fit& fit, std::span<const int> weights) const;
  const AxisBlocks& training_;
  AxisScale scale_;
};

}  // namespace m100::lab::identify
