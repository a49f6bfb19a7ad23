// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/loop/hidden_plants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/loop/results.h"
#include "host_tests/sim/world/base_plant.h"

namespace m100::lab::loop {
namespace {

TEST(Loop, FindsNothingWhereTheVehicleFileIsThePlantInTwentySeeds) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    expect_nothing_found(seed);
  }
}

// Regression test: six of twenty-three seeds were not "nothing missing", mostly because blocks of the second flight
// began just after a jump of the stick; the lead zero of this file enlarges the error of such a start. The goal is
// twenty of twenty.
TEST(Loop, FindsNothingMissingInTwentySeeds) {
  constexpr int kMaxRefused = 2;  // of twenty seeds
  int refused = 0;
  std::string messages;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::string one = without_a_clean_bill(seed, M100_IDENTIFIED_VEHICLE);
    refused += one.empty() ? 0 : 1;
    messages += one;
  }
  EXPECT_LE(refused, kMaxRefused) << messages;
}

// The measured plant has trims of 1080 and 998 and a dead zone in climb; the vehicle file has 1024 and no dead zone.
TEST(Loop, FindsTheTrimsAndTheDeadZoneOfTheMeasuredPlant) {
  const LoopResult result = found_on(sim::measured_plant(), 1);
  const auto found = [&](const char* channel, const std::string& parameter) {
    for (const identify::Refitted& one : result.believed_found.at(channel)) {
      if (one.parameter == parameter) {
        EXPECT_TRUE(one.matters) << channel << " " << parameter;
        EXPECT_EQ(one.believed, 0.0);
        return one.found.value;
      }
    }
    ADD_FAILURE() << channel << " lacks " << parameter;
    return 0.0;
  };
  EXPECT_NEAR(found("roll", "trim_counts"), 56.0, 2.0);
  EXPECT_NEAR(found("pitch", "trim_counts"), -26.0, 2.0);
  EXPECT_GT(found("climb", "dead_zone_counts"), 20.0);
  for (const char* channel : {"roll", "pitch", "climb"}) {
    EXPECT_EQ(result.taken_over.count(channel), 1U) << channel;
  }
  EXPECT_TRUE(predicted_worse(result).empty()) << predicted_worse(result).front();
}

// A roll axis with 120 ms of delay is identified as a lead zero that cancels a pole, for which no controller exists.
// Catches a loop that ends there without writing a result.
TEST(Loop, GoesOnWithoutWhatCannotBeControlled) {
  sim::Plant plant = sim::measured_plant();
  plant.roll.transport_delay_s = 0.12;
  const LoopResult result = found_on(plant, 1);
  EXPECT_EQ(uncontrollable(result.vehicle.vehicle), "");
  EXPECT_EQ(result.identified.count("pitch"), 1U);
}

// Result of the loop on one of the hidden plants.
struct PlantResult {
  Errors errors;
  /// Change of the prediction error 1 s ahead, for each axis in which something was hidden.
  std::vector<std::pair<const char*, double>> predictions{};
  double worst_other = -1.0;  ///< the largest change of the others
  std::string wrong_names{};  ///< named effects that the plant does not have
};

const std::array<std::pair<const char*, std::pair<model::StickAxis sim::Plant::*, model::StickAxis model::Vehicle::*>>,
                 4>
    kAxes{{{"roll", {&sim::Plant::roll, &model::Vehicle::roll}},
           {"pitch", {&sim::Plant::pitch, &model::Vehicle::pitch}},
           {"yaw_rate", {&sim::Plant::yaw_rate, &model::Vehicle::yaw_rate}},
           {"climb", {&sim::Plant::climb, &model::Vehicle::climb}}}};

bool differ(const model::AxisEffect& effect, const model::StickAxis& plant, const model::StickAxis& file) {
  return std::any_of(effect.numbers.begin(), effect.numbers.end(), [&](const model::AxisNumber& number) {
    return std::abs(plant.*number.member - file.*number.member) > number.min_relevant;
  });
}

// A delay that is named as a lead zero, which looks alike, counts as right, and vice versa; so do saturation and a
// limit of the tilt.
bool allowed(const std::string& name, const model::StickAxis& plant, const model::StickAxis& file) {
  for (const auto& same : {std::array{"transport_delay", "lead_zero"}, std::array{"saturation", "tilt_limit"}}) {
    for (const char* one : same) {
      const model::AxisEffect* effect = model::axis_effect(one);
      if ((name == same[0] || name == same[1]) && effect != nullptr && differ(*effect, plant, file)) {
        return true;
      }
    }
  }
  const model::AxisEffect* effect = model::axis_effect(name);
  return effect != nullptr && differ(*effect, plant, file);
}

double error_1s(const LoopEvaluation& side, const std::string& channel) {
  const auto* const found =
      std::find_if(identify::kQuantities.begin(), identify::kQuantities.end(),
                   [&](const identify::Quantity& quantity) { return channel == quantity.channel; });
  return (side.prediction.*found->member)[identify::kOneSecond];
}

PlantResult plant_result(const Hidden& hidden) {
  const sim::Plant plant = plant_of(hidden);
  const sim::Plant measured = sim::measured_plant();
  const LoopResult result = closed_on(hidden);
  PlantResult out{.errors = errors_of(result)};
  for (const auto& [channel, members] : kAxes) {
    const model::StickAxis& flown = plant.*members.first;
    const model::StickAxis& file = mpc::generated::kVehicle.*members.second;
    const model::StickAxis& usual = measured.*members.first;
    const double change = error_1s(result.after, channel) / error_1s(result.before, channel) - 1.0;
    if (std::any_of(model::kAxisEffects.begin(), model::kAxisEffects.end(),
                    [&](const model::AxisEffect& effect) { return differ(effect, flown, usual); })) {
      out.predictions.emplace_back(channel, change);
    } else {
      out.worst_other = std::max(out.worst_other, change);
    }
    if (const auto found = result.identified.find(channel); found != result.identified.end()) {
      for (const identify::EffectResult& effect : found->second.effects) {
        if (!allowed(effect.name, flown, file)) {
          out.wrong_names += std::string(hidden.name) + ": " + channel + ": " + effect.name + "\n";
        }
      }
    }
  }
  return out;
}

std::string row_of(const Hidden& hidden, const PlantResult& plant) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "| %s | %.3f | %.3f |", hidden.name, plant.errors.before_m,
                plant.errors.after_m);
  std::string row = text.data();
  for (const auto& [channel, change] : plant.predictions) {
    row += std::string(" ") + channel + " " + std::to_string(std::lround(100.0 * change)) + " %";
  }
  return row + " |\n";
}

std::string in_words(double change) {
  return std::to_string(std::lround(100.0 * std::abs(change))) + (change > 0.0 ? " % larger" : " % smaller");
}

// Goals: the prediction error 1 s ahead of the axes in which something was hidden falls by at least 40 % in the median;
// the trajectory error falls by 20 % in the median, and on no plant it grows by more than 3 %; no effect is named that
// the plant does not have. Something that matters is hidden in every plant.
TEST(Loop, FindsWhatTwelveHiddenPlantsHave) {
  std::vector<double> flown;
  std::vector<double> foretold;
  double worst_other = -1.0;
  std::string table = "| plant | before [m] | after [m] | change of the errors 1 s ahead |\n|---|---|---|---|\n";
  std::string wrong_names;
  for (const Hidden& hidden : kHiddenPlants) {
    const PlantResult plant = plant_result(hidden);
    table += row_of(hidden, plant);
    std::cout << row_of(hidden, plant) << std::flush;
    flown.push_back(plant.errors.change());
    EXPECT_LE(flown.back(), 0.03) << hidden.name;
    std::vector<double> here;
    for (const auto& [channel, change] : plant.predictions) {
      here.push_back(change);
    }
    EXPECT_LT(logs::median(here), -0.1) << hidden.name << ": the prediction did not improve";
    foretold.insert(foretold.end(), here.begin(), here.end());
    worst_other = std::max(worst_other, plant.worst_other);
    wrong_names += plant.wrong_names;
  }
  RecordProperty("figure.loop.plants", table);
  RecordProperty("figure.loop.median", in_words(logs::median(flown)));
  RecordProperty("figure.loop.worst", in_words(*std::max_element(flown.begin(), flown.end())));
  RecordProperty("figure.loop.foretold", in_words(logs::median(foretold)));
  RecordProperty("figure.loop.others", in_words(worst_other));
  EXPECT_LE(logs::median(flown), -0.2);
  EXPECT_LE(logs::median(foretold), -0.4);
  EXPECT_EQ(wrong_names, "");
}

}  // namespace
}  // namespace m100::lab::loop
