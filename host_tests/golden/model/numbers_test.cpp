// SPDX-License-Identifier: BSD-3-Clause
// Numbers that no program computes: the ranges of a vehicle file's keys, bounds and starts of the fits, the paper's
// results. A wrong one makes no program fail, so each is written a second time in numbers.txt.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/model/axis_effects.h"
#include "firmware/model/paper.h"
#include "firmware/model/translation.h"

namespace m100::golden {
namespace {

template <typename... Word>
std::string line(const Word&... words) {
  std::ostringstream out;
  out.precision(10);
  const char* between = "";
  ((out << between << words, between = " "), ...);
  return out.str();
}

template <typename T>
void keys(std::vector<std::string>& out, const char* section, std::span<const companion::NumberKey<T>> all) {
  for (const companion::NumberKey<T>& key : all) {
    out.push_back(line("key", section, key.key, key.low, key.high, key.only_if_set));
  }
}

void axis_effects(std::vector<std::string>& out) {
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    out.push_back(line("effect", effect.name, effect.variant, effect.needs, effect.not_beside, effect.needs_other_stick,
                       effect.in_every_model, effect.typical.size, static_cast<int>(effect.typical.of),
                       static_cast<int>(effect.in_flight)));
    for (const model::AxisNumber& number : effect.numbers) {
      out.push_back(line("number", effect.name, number.parameter, number.field_name(), static_cast<int>(number.unit),
                         number.fit.low, number.fit.high, number.logarithmic, number.step, number.min_relevant,
                         number.neutral));
    }
    for (const std::array<double, 3>& start : effect.starts) {
      out.push_back(line("start", effect.name, start[0], start[1], start[2]));
    }
  }
}

void translation_effects(std::vector<std::string>& out) {
  for (const model::TranslationEffect& effect : model::kTranslationEffects) {
    out.push_back(line("translation", effect.name, effect.place, effect.min_relevant, effect.columns,
                       static_cast<int>(effect.acts), static_cast<int>(effect.drag), effect.needs.velocity,
                       effect.needs.thrust_set_point, effect.needs.tilt_in_thrust, effect.is_periodic,
                       effect.equivalent, static_cast<int>(effect.in_flight)));
    for (std::size_t i = 0; i < effect.parameter_count(); ++i) {
      const model::EffectParameter& one = effect.parameters[i];
      out.push_back(line("parameter", effect.name, one.name, one.low, one.high, one.neutral, one.key, one.only_if_set));
    }
    for (std::size_t i = 0; i < effect.searched_count(); ++i) {
      const model::SearchedParameter& one = effect.searched[i];
      out.push_back(line("searched", effect.name, one.low, one.high, one.first_step, one.last_step, one.repeated_step,
                         one.turn, static_cast<int>(one.start), one.value_count, one.values[0], one.values[1],
                         one.values[2], one.values[3]));
    }
  }
}

void paper_results(std::vector<std::string>& out) {
  using namespace model::paper;
  for (const auto& [name, column] :
       {std::pair{"hover_calm", kHoverCalm}, std::pair{"hover_wind", kHoverWind}, std::pair{"step_calm", kStepCalm},
        std::pair{"step_wind", kStepWind}, std::pair{"trajectory_calm", kTrajectoryCalm},
        std::pair{"trajectory_wind", kTrajectoryWind}, std::pair{"simulator", kTrajectorySimulator}}) {
    out.push_back(line("paper", name, column.pose_m, column.x_m, column.y_m, column.z_m, column.roll_deg,
                       column.pitch_deg, column.yaw_deg, column.from_s, column.to_s));
  }
}

void paper_models(std::vector<std::string>& out) {
  using namespace model::paper;
  for (const Experiment& scale : {kScaleRoll_rad_per_count, kScalePitch_rad_per_count, kScaleYawRate_rad_s_per_count,
                                  kScaleClimb_m_s_per_count}) {
    out.push_back(line("paper_scale", scale.experiment, scale.simulator));
  }
  for (const FirstOrder& first : {kRollFirst, kPitchFirst, kYawRateFirst, kYawRateFirstTable2, kClimbFirst}) {
    out.push_back(line("paper_first", first.gain, first.time_constant_s));
  }
  for (const SecondOrder& second : {kRollSecond, kPitchSecond, kYawRateSecond, kClimbSecond}) {
    out.push_back(line("paper_second", second.gain, second.damping_ratio, second.natural_frequency_rad_s));
  }
  out.push_back(line("paper_sticks", kNeutral_vrc, kTravel_vrc, kRollBalance_vrc, kPitchBalance_vrc, kTiltDeadZone_vrc,
                     kClimbDeadZone_vrc, kYawRateDeadZone_vrc, kScaleLinear_rad_per_count, kPitchTimeConstantTable2_s));
  out.push_back(line("paper_height", kAltitudeKp, kAltitudeKi, kAltitudeKd, kAltitudeIntegralLimit));
  out.push_back(line("paper_flight", kHorizon, kMass_kg, kPayload_kg, kFanWindLow_m_s, kFanWindHigh_m_s));
}

TEST(Numbers, AreThoseThatStandInTheTable) {
  std::vector<std::string> is;
  keys(is, "tilt", companion::axis_keys(model::AxisUnit::kTilt_rad));
  keys(is, "yaw_rate", companion::axis_keys(model::AxisUnit::kYawRate_rad_s));
  keys(is, "climb", companion::axis_keys(model::AxisUnit::kClimb_m_s));
  keys(is, "translation", companion::translation_keys());
  keys(is, "mpc", companion::mpc_keys());
  keys(is, "estimator", companion::estimator_keys());
  keys(is, "altitude", companion::altitude_keys());
  keys(is, "yaw", companion::yaw_keys());
  axis_effects(is);
  translation_effects(is);
  paper_results(is);
  paper_models(is);
  std::vector<std::string> was;
  std::ifstream file("host_tests/golden/model/numbers.txt");
  for (std::string text; std::getline(file, text);) {
    was.push_back(text);
  }
  for (std::size_t i = 0; i < std::max(is.size(), was.size()); ++i) {
    EXPECT_EQ(i < is.size() ? is[i] : "", i < was.size() ? was[i] : "") << "line " << i + 1;
  }
}

}  // namespace
}  // namespace m100::golden
