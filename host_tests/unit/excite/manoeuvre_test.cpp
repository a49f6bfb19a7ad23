// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/excite/manoeuvre.h"
#include "host_tests/lab/excite/forecast.h"
#include "host_tests/refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace m100::lab::excite {
namespace {

const model::StickAxis kAxis{
    .scale_per_count = 9.3e-4, .natural_frequency_rad_s = 8.7, .damping_ratio = 0.68, .dead_zone_counts = 16.0};

class Kind : public ::testing::TestWithParam<std::string> {};

TEST_P(Kind, StaysInsideTheFence) {
  for (const double fence_m : {3.0, 8.0}) {
    const InputDesign design{.kind = GetParam(), .amplitude_counts = 400.0, .duration_s = 60.0, .fence_m = fence_m};
    const Manoeuvre made = design_manoeuvre(design, kAxis);
    EXPECT_LE(made.farthest_m, fence_m);
    EXPECT_GE(static_cast<double>(made.stick_counts.size()) * made.period_s, 60.0);
    EXPECT_LE(*std::max_element(made.stick_counts.begin(), made.stick_counts.end()), 660.0);
    EXPECT_LT(std::abs(made.position_m.back()), 1.0) << "it ends where it began";
  }
}

INSTANTIATE_TEST_SUITE_P(All, Kind, ::testing::Values("doublet", "3211", "chirp", "mixed", "sweep"),
                         [](const auto& tested) { return "k" + tested.param; });

// Catches a sweep that jumps over the dead zone: its ramps must pass every count of it slowly, to either side.
TEST(Sweep, PassesTheDeadZoneSlowly) {
  const Manoeuvre made = design_manoeuvre({.kind = "sweep", .amplitude_counts = 150.0, .fence_m = 12.0}, kAxis);
  std::size_t inside = 0, high = 0, low = 0;
  for (std::size_t k = 1; k < made.piece.size(); ++k) {
    const bool goes_on = made.piece[k] != 0 && made.piece[k] == made.piece[k - 1];
    const double step = std::abs(made.stick_counts[k] - made.stick_counts[k - 1]);
    if (goes_on && step > 0.0 && step < 5.0) {
      inside += std::abs(made.stick_counts[k]) <= 60.0 ? 1U : 0U;
      high += made.stick_counts[k] > 60.0 ? 1U : 0U;
      low += made.stick_counts[k] < -60.0 ? 1U : 0U;
    }
  }
  EXPECT_GT(static_cast<double>(inside) * made.period_s, 6.0);
  EXPECT_GT(high, 0U);
  EXPECT_GT(low, 0U);
}

// Catches a piece that runs for seconds without a margin: a small error of the trim then carries the aircraft over the
// fence.
TEST(Fit, HoldsThoughSomethingPushesThroughEveryPiece) {
  constexpr double kPush_m_s2 = 0.25;
  for (const double fence_m : {1.5, 3.0, 6.0}) {
    const InputDesign design{.amplitude_counts = 150.0, .duration_s = 60.0, .fence_m = fence_m};
    const Manoeuvre made = design_manoeuvre(design, kAxis);
    double into_s = 0.0;
    for (std::size_t k = 1; k < made.piece.size(); ++k) {
      const bool goes_on = made.piece[k] != 0 && made.piece[k] == made.piece[k - 1];
      into_s = goes_on ? into_s + made.period_s : 0.0;
      for (const double push : {-kPush_m_s2, kPush_m_s2}) {
        EXPECT_FALSE(goes_on && must_abort(made.position_m[k] + 0.5 * push * into_s * into_s,
                                           made.speed_m_s[k] + push * into_s, design))
            << fence_m << " m, piece " << made.piece[k] << " after " << into_s << " s";
      }
    }
  }
}

// Catches slow movements, which show dead zone and trim, that are left out in a small room instead of being flown in
// parts.
TEST(Fit, SplitsWhatIsTooLongForTheFence) {
  const Manoeuvre wide = design_manoeuvre({.amplitude_counts = 150.0, .fence_m = 20.0}, kAxis);
  EXPECT_EQ(wide.in_parts, 0);
  EXPECT_DOUBLE_EQ(wide.min_amplitude_counts, 150.0);
  const Manoeuvre small = design_manoeuvre({.amplitude_counts = 150.0, .fence_m = 3.0}, kAxis);
  EXPECT_EQ(small.in_parts, 2) << "sweep and chirp";
  EXPECT_EQ(small.left_out, 0);
  EXPECT_DOUBLE_EQ(small.min_amplitude_counts, 150.0);
}

TEST(Fit, NamesTheFenceThatWouldBeEnough) {
  const auto design = [] { design_manoeuvre({.amplitude_counts = 150.0, .fence_m = 0.2}, kAxis); };
  EXPECT_EQ(host_tests::refusal_by<std::invalid_argument>(design),
            "--fence: 0.2 is too small for any manoeuvre of this vehicle; 0.5 is enough");
}

TEST(Abort, LeavesRoomToBrake) {
  const InputDesign design{.fence_m = 8.0, .brake_m_s2 = 2.0};
  EXPECT_FALSE(must_abort(7.0, 1.9, design));
  EXPECT_TRUE(must_abort(7.0, 2.1, design));
  EXPECT_FALSE(must_abort(7.0, -5.0, design)) << "it flies inwards";
  EXPECT_TRUE(must_abort(-7.0, -2.1, design));
}

const Forecast& of(const std::vector<Forecast>& table, const std::string& effect) {
  return *std::find_if(table.begin(), table.end(), [&](const Forecast& one) { return one.effect == effect; });
}

// Catches a forecast that does not depend on the manoeuvre: a longer flight must show each effect more clearly.
TEST(Forecast, SaysThatLongerFlightsShowMore) {
  const InputDesign brief{.duration_s = 20.0, .fence_m = 20.0};
  const InputDesign longer{.duration_s = 80.0, .fence_m = 20.0};
  const auto a = forecast(design_manoeuvre(brief, kAxis), kAxis);
  const auto b = forecast(design_manoeuvre(longer, kAxis), kAxis);
  for (const char* effect : {"dead_zone", "trim_offset", "gain_asymmetry"}) {
    EXPECT_GT(of(b, effect).sigma, 1.5 * of(a, effect).sigma) << effect;
  }
}

TEST(Forecast, SaysThatMixedManoeuvresTellDeadZoneFromCurveBetterThanDoublets) {
  const auto doublets =
      forecast(design_manoeuvre({.kind = "doublet", .amplitude_counts = 250, .fence_m = 20}, kAxis), kAxis);
  const auto mixed =
      forecast(design_manoeuvre({.kind = "mixed", .amplitude_counts = 250, .fence_m = 20}, kAxis), kAxis);
  EXPECT_LT(of(mixed, "dead_zone").cosine, of(doublets, "dead_zone").cosine);
}

const model::StickAxis kClimb{.scale_per_count = 3e-3, .natural_frequency_rad_s = 5.0, .damping_ratio = 0.8};

// Catches a climb that is planned like a tilt: its fence limits the height, and it must return to its start.
TEST(RateAxis, StaysInsideItsFenceAndComesBack) {
  for (const char* kind : {"doublet", "3211", "chirp", "mixed"}) {
    const InputDesign design{
        .axis = "climb", .kind = kind, .amplitude_counts = 300.0, .duration_s = 60.0, .fence_m = 2.0, .rate = true};
    const Manoeuvre made = design_manoeuvre(design, kClimb);
    EXPECT_LE(made.farthest_m, 2.0) << kind;
    EXPECT_LT(std::abs(made.position_m.back()), 0.6) << kind;
  }
}

TEST(InputDesign, ThatMakesNoSenseIsRefused) {
  EXPECT_THROW(design_manoeuvre({.amplitude_counts = -1}, kAxis), std::invalid_argument);
  EXPECT_THROW(design_manoeuvre({.kind = "wiggle"}, kAxis), std::invalid_argument);
  EXPECT_THROW(design_manoeuvre({.fence_m = 0}, kAxis), std::invalid_argument);
}

}  // namespace
}  // namespace m100::lab::excite
