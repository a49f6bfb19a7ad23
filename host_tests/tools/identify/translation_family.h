// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"
#include "host_tests/tools/identify/selection.h"
#include "host_tests/tools/identify/translation_data.h"

namespace m100::tools::identify {

/// Models of translation: "rigid_body", then effects.
///
///   a = (1 + gains) T b3 - g e3 + wind + Rz(yaw) bias - (k + c |v - w|) (v - w) - i (b3 . v) b3 + periodic,
///
/// with T after a first-order lag, T and b3 taken time_offset seconds earlier. Linear in all but lag, offset, the
/// line's frequency, and the wind speed w where there are wind and quadratic drag; those four are searched around the
/// linear solution. Wind and drag are one model: at v = 0 the drag of the wind is what is reported as its acceleration.
class TranslationFamily final : public Family {
 public:
  explicit TranslationFamily(const TranslationBlocks& training);

  std::size_t block_count() const override { return training_.blocks.size(); }
  std::size_t samples_in(std::size_t block) const override {
    return training_.blocks[block].samples.size() * training_.data->axes;
  }
  Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const override;
  std::vector<double> error(const Fit& fit, std::size_t block) const override;
  std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const override;
  std::vector<Edit> edits(const Structure& present) const override;
  Structure without(const Structure& structure, const std::string& name) const override;
  bool big_enough(const Fit& fit, const std::string& name) const override;
  bool alias(const Fit& winner, const std::string& name, const std::string& rival) const override;

  /// Predicted acceleration, in the rows of `part`, which may be of another log.
  static std::vector<double> prediction(const TranslationBlocks& part, const Fit& fit);
  /// Measured acceleration in the same rows.
  static std::vector<double> measured(const TranslationBlocks& part);

  /// What an effect's numbers are, as the JSON spells them; computed from the fit's own parameters.
  static std::vector<NamedValue> parameters(const Fit& fit, const std::string& effect);

  static bool knows(const std::string& name);
  /// Whether the log has what the effect acts on.
  bool can_see(const std::string& name) const;

  /// Why a periodic force may not be claimed although its line is there; empty: it may.
  std::string own_motion_at(const Fit& fit) const;

  /// How far a log without thrust set point prefers the rigid body of `other` over that of `present`, which are the
  /// same samples: the coefficient of their difference beside all linear effects and the strongest line. About 0 or 1.
  static double preference(const TranslationBlocks& present, const TranslationBlocks& other);

 private:
  /// Whether a line fitted to the first part of the training predicts the rest: a force with its own clock does, what
  /// swings and is shaken anew does not.
  bool keeps_time(const Fit& fit) const;
  static constexpr std::size_t kStartSize = 6;
  /// Wind speeds to start from, for a few drag coefficients.
  std::vector<std::array<double, kStartSize>> wind_starts(const std::vector<std::array<double, kStartSize>>& starts,
                                                          const Structure& structure,
                                                          std::span<const int> weights) const;

  const TranslationBlocks& training_;
};

}  // namespace m100::tools::identify
