// SPDX-License-Identifier: BSD-3-Clause
// Flies the worst fault that the search has found in each channel (promise R14), and tests the search itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "host_tests/scenario/sensor_faults/recorded_faults.h"

namespace m100::scenario {
namespace {

constexpr std::uint64_t kSeeds = 2;
constexpr double kBrakes_m = 2.5;  ///< farthest, from where the fault is noticed until the pilot has control

class WorstFault : public ::testing::TestWithParam<std::string_view> {};

TEST_P(WorstFault, TakesTheAircraftNoFartherThanItDid) {
  RecordProperty("promise", "R14");
  const auto recorded = recorded_faults(M100_WORST_FAULTS);
  const Channel& channel = channel_of(GetParam());
  ASSERT_TRUE(recorded.contains(channel.name)) << "worst_faults.txt has no fault of this channel";
  const RecordedFault& worst = recorded.find(channel.name)->second;
  FaultEffect max{.after_s = 0.0};
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const FaultEffect effect = effect_of(channel, worst.fault, seed);
    EXPECT_LE(score_of(channel, effect), worst.limit_m) << "seed " << seed;
    EXPECT_LE(effect.went_on_m, kBrakes_m) << "seed " << seed;
    max.after_s = std::max(max.after_s, effect.after_s);
    max.away_m = std::max(max.away_m, effect.away_m);
    max.farthest_m = std::max(max.farthest_m, effect.farthest_m);
  }
  char when[32];
  static_cast<void>(std::snprintf(when, sizeof when, "%.1f s", max.after_s));
  char text[96];
  static_cast<void>(std::snprintf(text, sizeof text, "%.2f m | %s | %.2f m", max.away_m,
                                  max.after_s == FaultEffect::kNever ? "not noticed" : when, max.farthest_m));
  RecordProperty("figure.searched." + std::string(channel.name), text);
  std::printf("%s | %s\n", std::string(channel.name).c_str(), text);
}

std::vector<std::string_view> all_names() {
  std::vector<std::string_view> names;
  for (const Channel& channel : channels()) {
    names.push_back(channel.name);
  }
  return names;
}
INSTANTIATE_TEST_SUITE_P(Channels, WorstFault, ::testing::ValuesIn(all_names()), [](const auto& tested) {
  std::string name(tested.param);
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

// Catches a channel whose faults never reach the program. Two channels are missing: the height is not used in flight,
// and gross rates are rejected without a message; the worst fault of the rates shows that they reach the program.
TEST(Fault, ThatIsGrossIsNoticed) {
  const std::pair<const char*, const char*> gross[] = {{"pose.position", "hover | bias 2 30 0 2 1 0 0"},
                                                       {"pose.heading", "hover | bias 2 30 0 2 1 0 0"},
                                                       {"attitude", "hover | bias 2 30 0 1 1 0 0"},
                                                       {"force", "hover | bias 2 30 0 1 1 0 0"},
                                                       {"velocity", "hover | bias 2 30 0 5 0 0 1"},
                                                       {"answers", "hover | says_pilots 2 4"},
                                                       {"operator", "hover | release 2 0"}};
  for (const auto& [name, text] : gross) {
    const Channel& channel = channel_of(name);
    EXPECT_LT(effect_of(channel, fault_of(channel, text), 1).after_s, 15.0) << name;
  }
}

Value reported_at(const std::string& text, double t_s, const Value& truth) {
  WaveformInjector injector(waveform_of(text), 1);
  std::optional<Value> last;
  for (int tick = 0; tick <= static_cast<int>(std::lround(100.0 * t_s)); ++tick) {
    last = injector.apply(0.01 * tick, truth * (0.01 * tick), true);
  }
  return last.value_or(Value::Constant(-1.0));
}

// Catches kinds of pieces that have no effect.
TEST(Waveform, ChangesTheValueAsItSays) {
  const Value ramp(1.0, 0.0, 2.0);  // true value per second of time
  const auto expect = [&](const std::string& text, double t_s, const Value& wanted) {
    EXPECT_NEAR((reported_at(text, t_s, ramp) - wanted).norm(), 0.0, 1e-9) << text << " at " << t_s;
  };
  expect("bias 1 2 0 0.5 1 0 0", 0.5, {0.5, 0.0, 1.0});
  expect("bias 1 2 0 0.5 1 0 0", 2.0, {2.5, 0.0, 4.0});
  expect("bias 1 2 2 0.5 1 0 0", 2.0, {2.25, 0.0, 4.0});  // half faded in
  expect("bias 1 2 0 0.5 1 0 0", 4.0, {4.0, 0.0, 8.0});
  expect("drift 1 2 0 0.5 0 1 0", 2.0, {2.0, 0.5, 4.0});
  expect("drift 1 2 0 0.5 0 1 0", 5.0, {5.0, 1.0, 10.0});  // the offset remains
  expect("swing 1 9 4 0.5 0 1 0", 2.0, {2.0, 0.5, 4.0});   // at a quarter of its period
  expect("delay 1 9 0 0.5 1 0 0", 3.0, {2.5, 0.0, 5.0});
  expect("gain 1 9 0 1 1 0 0", 3.0, {5.0, 0.0, 10.0});  // beginning at 1 and 2, twice the change
  expect("sign 1 9 0 0 1 0 0", 3.0, {-1.0, 0.0, 6.0});  // x mirrored at 1
  expect("dropout 1 9 0 0 1 0 0", 3.0, Value::Constant(-1.0));
  EXPECT_GT((reported_at("noise 1 9 0 0.5 0 1 0", 3.0, ramp) - Value(3.0, 0.0, 6.0)).norm(), 0.0);
}

TEST(Fault, IsReadAsItWasWritten) {
  const std::string wave = "step_3m | gain 1.5 2 0.25 -0.5 0 1 0; dropout 2 0.1 0 0 1 0 0";
  EXPECT_EQ(to_text(fault_of(channel_of("rates"), wave)), wave);
  const std::string words = "hover | release 1.5 0; engage 2 0";
  EXPECT_EQ(to_text(fault_of(channel_of("operator"), words)), words);
  EXPECT_THROW(static_cast<void>(fault_of(channel_of("rates"), "hover | dropped 1 2")), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(fault_of(channel_of("rates"), "hover")), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(channel_of("weather")), std::invalid_argument);
}

// The search must be reproducible, so that its result can be kept.
TEST(Search, FindsTheSameAgain) {
  const Channel& channel = channel_of("height");
  EXPECT_EQ(to_text(run_search(channel, 3, 7, {}).fault), to_text(run_search(channel, 3, 7, {}).fault));
}

}  // namespace
}  // namespace m100::scenario
