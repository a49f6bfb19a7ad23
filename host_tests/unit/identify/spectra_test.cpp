// SPDX-License-Identifier: BSD-3-Clause
// Spectra, frequency response and correlations of the report, on series for which they are known.
#include "host_tests/lab/identify/output/spectra.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace m100::lab::identify {
namespace {

constexpr double kPeriod_s = 0.01;

std::vector<double> noise(std::size_t samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> out(samples);
  for (double& value : out) {
    value = normal(random);
  }
  return out;
}

// Catches a density that is wrong by the power of the window, by a factor of two, or by the sample period.
TEST(Welch, DensityOfWhiteNoiseSumsToItsPower) {
  const std::vector<double> white = noise(60000, 1);
  const Spectra spectra = welch(white, white, {{0, white.size()}}, kPeriod_s);
  const double width_hz = spectra.frequency_hz[1] - spectra.frequency_hz[0];
  EXPECT_NEAR(width_hz * std::accumulate(spectra.output.begin(), spectra.output.end(), 0.0), 1.0, 0.03);
  EXPECT_NEAR(spectra.frequency_hz.back(), 50.0, 1e-9) << "half of the sample rate";
}

// First-order lag: 1 / (1 + j w tau). Catches a response that is inverted or conjugated.
TEST(Welch, ResponseOfAFirstOrderIsThatOfTheFormula) {
  constexpr double kTau_s = 0.2;
  const std::vector<double> input = noise(200000, 2);
  std::vector<double> output(input.size(), 0.0);
  const double keep = std::exp(-kPeriod_s / kTau_s);
  for (std::size_t k = 1; k < input.size(); ++k) {
    output[k] = keep * output[k - 1] + (1.0 - keep) * input[k];
  }
  const Spectra spectra = welch(input, output, {{0, input.size()}}, kPeriod_s);
  for (const std::size_t k : {2U, 5U, 10U}) {
    const double omega = 2.0 * std::numbers::pi * spectra.frequency_hz[k];
    const std::complex<double> expected = 1.0 / std::complex<double>(1.0, omega * kTau_s);
    EXPECT_NEAR(std::abs(spectra.response(k)), std::abs(expected), 0.05 * std::abs(expected));
    EXPECT_NEAR(std::arg(spectra.response(k)), std::arg(expected), 0.1);
    EXPECT_GT(spectra.coherence(k), 0.95);
  }
}

TEST(Welch, CoherenceIsTheShareThatFollowsTheInput) {
  const std::vector<double> input = noise(200000, 3);
  const std::vector<double> other = noise(200000, 4);
  std::vector<double> output(input.size());
  for (std::size_t k = 0; k < input.size(); ++k) {
    output[k] = input[k] + other[k];
  }
  const Spectra spectra = welch(input, output, {{0, input.size()}}, kPeriod_s);
  double mean = 0.0;
  for (std::size_t k = 0; k < spectra.frequency_hz.size(); ++k) {
    mean += spectra.coherence(k) / static_cast<double>(spectra.frequency_hz.size());
  }
  EXPECT_NEAR(mean, 0.5, 0.02);
}

TEST(Welch, HasNoSegmentAcrossAHole) {
  const std::vector<double> white = noise(900, 5);
  EXPECT_EQ(welch(white, white, {{0, 450}, {450, 900}}, kPeriod_s).segments, 0U) << "4.5 s each; a segment has 5.12 s";
  EXPECT_EQ(welch(white, white, {{0, 900}}, kPeriod_s).segments, 2U);
}

TEST(Stretches, EndWhereTimeJumps) {
  std::vector<double> t_s{0.0, 0.01, 0.02, 1.0, 1.01, 0.5, 0.51};
  const auto found = stretches(t_s, kPeriod_s);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[1], (std::pair<std::size_t, std::size_t>{3, 5}));
}

// The output is the input 30 samples earlier: the peak must lie at +30, not at -30.
TEST(CrossCorrelation, FindsWhatComesLater) {
  const std::vector<double> input = noise(5000, 6);
  std::vector<double> later(input.size(), 0.0);
  for (std::size_t k = 30; k < input.size(); ++k) {
    later[k] = input[k - 30];
  }
  EXPECT_NEAR(cross_correlation(input, later, 30, {{0, input.size()}}), 1.0, 0.02);
  EXPECT_NEAR(cross_correlation(input, later, -30, {{0, input.size()}}), 0.0, 0.06);
}

// Catches the confidence band of white noise applied to coloured series: one in two independent pairs would exceed it.
TEST(IndependentBand, HoldsNineteenOfTwentyPairsOfColouredSeries) {
  int inside = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::vector<double> a = noise(3000, 100 + seed);
    std::vector<double> b = noise(3000, 1000 + seed);
    for (std::size_t k = 1; k < a.size(); ++k) {
      a[k] += 0.95 * a[k - 1];
      b[k] += 0.95 * b[k - 1];
    }
    const double found = cross_correlation(a, b, 7, {{0, a.size()}});
    inside += std::abs(found) < independent_band(a, b, 100, {{0, a.size()}}) ? 1 : 0;
  }
  EXPECT_GE(inside, 180);
  EXPECT_LE(inside, 199);
}

}  // namespace
}  // namespace m100::lab::identify
