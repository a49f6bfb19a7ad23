// SPDX-License-Identifier: BSD-3-Clause
// If a named effect is withdrawn, its cause stays unexplained, whatever a second study finds.
#include <gtest/gtest.h>

#include "host_tests/lab/identify/selection/problem.h"

namespace m100::lab::identify {
namespace {

/// A family whose models all fit equally well.
class Constant final : public Family {
 public:
  std::size_t block_count() const override { return 6; }
  std::size_t samples_in(std::size_t) const override { return 10; }
  Fit fit(const Structure& structure, std::span<const int>, const Fit*) const override {
    return {.structure = structure, .parameters = {}, .shape = "", .sum_of_squares = 1.0, .free_parameters = 0};
  }
  std::vector<std::vector<double>> errors(const Fit&, std::span<const int>) const override {
    return std::vector<std::vector<double>>(6, std::vector<double>(10, 0.1));
  }
  std::vector<Edit> edits(const Structure&) const override { return {}; }
  Structure without(const Structure&, const std::string&) const override { return {"rigid_body"}; }
  bool is_significant(const Fit&, const std::string&) const override { return true; }
};

/// A study that sees a second cause beside the named effect, and sees nothing once the name is gone.
class Shadow final : public Problem {
 public:
  const Family& family() const override { return family_; }
  double validation_rmse(const Fit&) const override { return 0.1; }
  std::vector<std::vector<double>> validation_errors(const Fit& fit) const override { return family_.errors(fit, {}); }
  ModelResult errors_of(const Fit&) const override {
    ModelResult out;
    out.fit_percent = 90.0;
    return out;
  }
  std::vector<Parameter> parameters(const Fit&) const override { return {}; }
  std::vector<double> coordinates(const Fit&) const override { return {}; }
  double reported(const Fit&, std::size_t, double coordinate) const override { return coordinate; }
  void examine(const Selection& selection, IdentifyResult& result) const override {
    if (!selection.steps.empty()) {
      result.unexplained.emplace_back("periodic 0.31 Hz");
    }
  }
  bool are_side_effects(const Selection&, const IdentifyResult&) const override { return true; }
  void annotate(const Selection&, IdentifyResult&) const override {}
  Traces traces(const Fit&, const Fit&) const override { return {}; }

 private:
  Constant family_;
};

TEST(WithdrawnGuess, LeavesTheCauseUnexplained) {
  Selection selection;
  selection.declared.fit.structure = {"rigid_body"};
  selection.final_model.fit.structure = {"rigid_body", "linear_drag"};
  selection.steps.emplace_back().name = "linear_drag";
  const logs::FlightLog log;
  Request request;
  request.log = &log;
  request.axis = "translation";
  request.refits = 0;
  const IdentifyResult result = conclude(Shadow{}, request, selection, {});
  EXPECT_TRUE(result.effects.empty());
  EXPECT_EQ(result.unexplained, std::vector<std::string>{"periodic 0.31 Hz"});
  EXPECT_EQ(result.verdict, "unexplained");
}

}  // namespace
}  // namespace m100::lab::identify
