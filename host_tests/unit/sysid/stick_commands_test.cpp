// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/stick_commands.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"

namespace m100::lab::identify {
namespace {

// Catches a result that is used again although a number of it has changed, and a curve that is not the law's.
TEST(StickCommands, AreThoseOfTheLawWhateverWasAskedBefore) {
  AxisData data;
  for (int i = 0; i < 500; ++i) {
    data.stick.push_back(std::round(640.0 * std::sin(1e-4 * i * i)));
    data.other.push_back(300.0 * std::cos(0.02 * i));
  }
  StickCommands commands(true);
  commands.add({0, 0, 500});
  model::StickAxis base{.scale_per_count = 2e-3, .time_constant_s = 0.2, .gain_asymmetry = 1.3, .trim_counts = 12.0};
  base.stick_exponent = 1.55;
  using Number = double model::StickAxis::*;
  for (const auto& [number, value] :
       std::initializer_list<std::pair<Number, double>>{{&model::StickAxis::scale_per_count, 3e-3},
                                                        {&model::StickAxis::stick_exponent, 0.4},
                                                        {&model::StickAxis::time_constant_s, 0.3},
                                                        {&model::StickAxis::dead_zone_counts, 20.0},
                                                        {&model::StickAxis::cross_axis, 0.2},
                                                        {&model::StickAxis::backlash_counts, 15.0},
                                                        {&model::StickAxis::gain_drift_per_minute, 0.5},
                                                        {&model::StickAxis::saturation, 0.4}}) {
    model::StickAxis moved = base;
    moved.*number = value;
    for (const model::StickAxis& axis : {base, moved}) {
      model::StickLaw<double> law(axis, data.period_s);
      const std::vector<double>& found = commands.of(data, axis, 0);
      for (std::size_t i = 0; i < found.size(); ++i) {
        const double wanted = law.command(data.stick[i], data.other[i], data.since_begin_s(i));
        ASSERT_NEAR(found[i], wanted, 1e-12 * (1.0 + std::abs(wanted))) << value << " at " << i;
      }
    }
  }
}

}  // namespace
}  // namespace m100::lab::identify
