// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/sysid/axis_model.h"
#include "firmware/sysid/levenberg_marquardt.h"
#include "host_tests/tools/identify/axis_blocks.h"
#include "host_tests/tools/identify/selection.h"

namespace m100::tools::identify {

/// What the training data say about sizes, so that starts and bounds suit any unit and any aircraft.
struct AxisScale {
  double stick = 1.0;           ///< 98 % of the sticks are smaller [counts]
  double gain = 1.0;            ///< first guess, unit per count
  double response = 1.0;        ///< 98 % of the measured values are smaller
  double rate_per_s = 1.0;      ///< likewise of its slope
  double minimum_counts = 1.0;  ///< one count, or its like where the log holds commands in SI units
};
AxisScale scale_of(const AxisBlocks& training);

/// The models of one stick axis: base "first_order" or "second_order", then effects by their names in the contract.
class AxisFamily final : public Family {
 public:
  explicit AxisFamily(const AxisBlocks& training);

  std::size_t block_count() const override { return training_.size(); }
  std::size_t samples_in(std::size_t block) const override { return training_[block].end - training_[block].begin; }
  Fit fit(const Structure& structure, std::span<const int> weights, const Fit* warm) const override;
  Fit polish(const Fit& fit, std::span<const int> weights) const override;
  std::vector<double> error(const Fit& fit, std::size_t block) const override;
  std::vector<std::vector<double>> errors(const Fit& fit, std::span<const int> weights) const override;
  std::vector<Edit> edits(const Structure& present) const override;
  Structure without(const Structure& structure, const std::string& name) const override;
  bool big_enough(const Fit& fit, const std::string& name) const override;

  sysid::AxisModel<double> model(const Fit& fit) const;
  /// Names of the free parameters in order, as the JSON spells them, each with the effect it belongs to ("" : base).
  struct ParameterName {
    std::string effect;
    std::string name;
  };
  std::vector<ParameterName> parameter_names(const Structure& structure) const;
  /// A fit's parameter as a physical number.
  double physical(const Fit& fit, std::size_t parameter) const;
  const AxisScale& scale() const { return scale_; }

  static bool knows(const std::string& name);

 private:
  Fit run(Fit start, std::span<const int> weights, int iterations) const;
  /// The fit with a jump at the dead zone's edge. Its width is scanned: the error is flat in it between two stick
  /// positions, so that steps along a gradient leave it where it began.
  Fit with_jump(Fit fit, std::span<const int> weights) const;
  double sum_of_squares(const Fit& fit, std::span<const int> weights) const;
  const AxisBlocks& training_;
  AxisScale scale_;
};

}  // namespace m100::tools::identify
