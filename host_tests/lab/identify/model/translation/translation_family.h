// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/normal_equations.h"
#include "host_tests/lab/identify/model/translation/translation_regression.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// Models of translation: "rigid_body", then effects of model::kTranslationEffects.
///
///   a = thrust - g e3 + sum of the effects' columns times their linear parameters,
///
/// with thrust and its direction as the effects change them (firmware/model/translation_effect.h). The model is linear
/// except for the few parameters that effects declare as searched, which are searched around the linear solution. Wind
/// and drag are one model: the wind's reported acceleration is its drag at v = 0.
class TranslationFamily final : public Family {
 public:
  /// The blocks must outlive the family.
  explicit TranslationFamily(const TranslationBlocks& training);

  std::size_t block_count() const override { return training_.blocks.size(); }
  std::size_t axes() const override { return training_.data->axes; }
  std::size_t samples_in(std::size_t block) const override {
    return training_.blocks[block].samples.size() * training_.data->axes;
  }
  Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const override;
  std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const override;
  std::vector<Edit> edits(const Structure& present) const override;
  Structure without(const Structure& structure, const std::string& name) const override;
  bool is_significant(const Fit& fit, const std::string& name) const override;
  bool alias(const Fit& winner, const std::string& name, const std::string& rival) const override;

  /// Predicted acceleration, in the rows of `part`, which may be of another log.
  static std::vector<double> prediction(const TranslationBlocks& part, const Fit& fit);
  /// Measured acceleration in the rows of `part`.
  static std::vector<double> measured(const TranslationBlocks& part);

  /// The numbers of an effect with their JSON names, computed from the fit's own parameters. Empty for
  /// "rigid_body". Precondition: the fit's structure has the effect.
  static std::vector<NamedValue> parameters(const Fit& fit, const std::string& effect);

  static bool supports(const std::string& name);
  /// Whether the log can show the effect; false for the wind if --wind-from-first estimates it. Precondition:
  /// supports(name).
  bool is_observable(const std::string& name) const;

  /// Which thrust source explains the log better: about 0 for that of `present`, about 1 for that of `other`. It is the
  /// coefficient of their difference in a regression. Precondition: both have the same samples.
  static double preference(const TranslationBlocks& present, const TranslationBlocks& other);

 private:
  using Starts = std::vector<translation::SearchPoint>;
  /// Starting values of the parameters that `warm` does not have; the others are as in `common`.
  Starts starts(const Structure& structure, std::span<const int> weights, const Fit* warm,
                const translation::SearchPoint& common) const;
  /// Wind speeds to start from, for a few drag coefficients.
  Starts wind_starts(const Starts& starts, const Structure& structure, std::span<const int> weights) const;

  const TranslationBlocks& training_;
  mutable translation::NormalEquations normals_;  ///< cache
};

}  // namespace m100::lab::identify
