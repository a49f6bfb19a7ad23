// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>

#include "firmware/core/maths.h"

namespace m100::core {
namespace {

// The reference is the C library in long double, whose mantissa has 64 bits on x86-64. The measurement holds for all
// machines, because the golden hash shows the same bits everywhere. On armhf long double is no wider than double, and
// on aarch64 it is slow.
constexpr bool kHasJudge = std::numeric_limits<long double>::digits == 64;
constexpr int kArguments = 200000;

/// Error of `computed` in units of the last place of T at `exact`.
template <typename T>
double ulps(T computed, long double exact) {
  int exponent = 0;
  std::frexp(exact, &exponent);
  const int lowest = std::numeric_limits<T>::min_exponent;
  const int of_last_place = (exponent < lowest ? lowest : exponent) - std::numeric_limits<T>::digits;
  return static_cast<double>(std::fabs(std::ldexp(static_cast<long double>(computed) - exact, -of_last_place)));
}

/// Largest error over evenly spaced and random arguments (uniform, and logarithmically uniform for small arguments).
template <typename T, typename Ours, typename Exact>
double worst_ulps(T low, T high, Ours ours, Exact exact) {
  double worst = 0.0;
  const auto judge = [&](T x) {
    if (x >= low && x <= high) {
      worst = std::max(worst, ulps(ours(x), exact(static_cast<long double>(x))));
    }
  };
  std::mt19937_64 random(20171122);
  std::uniform_real_distribution<double> uniform(static_cast<double>(low), static_cast<double>(high));
  std::uniform_real_distribution<double> exponent(-60.0, std::log2(static_cast<double>(high)));
  for (int i = 0; i <= kArguments; ++i) {
    judge(low + (high - low) * (static_cast<T>(i) / static_cast<T>(kArguments)));
    judge(static_cast<T>(uniform(random)));
    const T small = static_cast<T>(std::exp2(exponent(random)));
    judge(small);
    judge(-small);
  }
  return worst;
}

template <typename T>
class MathsAccuracy : public ::testing::Test {
 protected:
  void SetUp() override {
    RecordProperty("promise", "R6");
    if (!kHasJudge) {
      GTEST_SKIP() << "measured on x86-64, whose long double is the reference";
    }
  }
  /// Checks the largest error against its bound, and in double records it as the figure ulp.<function> of a page. In a
  /// figure's name, an underscore replaces every character except letters and digits.
  void expect_at_most(double bound_ulp, const char* function, double worst) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "%.3f", worst);
    std::printf("%-28s %-6s %s ulp\n", function, sizeof(T) == 4 ? "float" : "double", text.data());
    if (sizeof(T) == 8) {
      std::string name = function;
      std::replace_if(
          name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
      RecordProperty("figure.ulp." + name, text.data());
    }
    EXPECT_LE(worst, bound_ulp) << function;
  }
};

struct TypeNames {
  template <typename T>
  static std::string GetName(int) {
    return sizeof(T) == 4 ? "Float" : "Double";
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(MathsAccuracy, Scalars, TypeNames);

// Bounds for both scalars: one unit for functions with one rounding after the reduction, two for a quotient of two
// rounded numbers. A wrong digit in any coefficient gives an error of thousands of units.
TYPED_TEST(MathsAccuracy, OfSineAndCosine) {
  using T = TypeParam;
  for (const T reach : {T(0.79), T(10), T(1e5)}) {
    const std::string range = " up to " + std::to_string(static_cast<int>(reach + T(0.5))) + " rad";
    const auto judged_sin = [](long double x) { return std::sin(x); };
    const auto judged_cos = [](long double x) { return std::cos(x); };
    this->expect_at_most(1.0, ("sin" + range).c_str(), worst_ulps<T>(-reach, reach, sin<T>, judged_sin));
    this->expect_at_most(1.0, ("cos" + range).c_str(), worst_ulps<T>(-reach, reach, cos<T>, judged_cos));
  }
}

TYPED_TEST(MathsAccuracy, OfTangent) {
  using T = TypeParam;
  const auto judged = [](long double x) { return std::tan(x); };
  this->expect_at_most(2.5, "tan up to 1.57 rad", worst_ulps<T>(T(-1.57), T(1.57), tan<T>, judged));
}

TYPED_TEST(MathsAccuracy, OfArcTangent) {
  using T = TypeParam;
  for (const T x : {T(1), T(-1), T(0.37), T(-2e4)}) {
    const auto ours = [x](T y) { return atan2<T>(y, x); };
    const auto judged = [x](long double y) { return std::atan2(y, static_cast<long double>(x)); };
    const std::string label = "atan2(y, " + std::to_string(static_cast<double>(x)) + ")";
    this->expect_at_most(1.5, label.c_str(), worst_ulps<T>(T(-30), T(30), ours, judged));
  }
}

TYPED_TEST(MathsAccuracy, OfArcSine) {
  using T = TypeParam;
  const auto judged = [](long double x) { return std::asin(x); };
  this->expect_at_most(3.0, "asin", worst_ulps<T>(T(-1), T(1), asin<T>, judged));
}

TYPED_TEST(MathsAccuracy, OfTheExponential) {
  using T = TypeParam;
  const auto judged = [](long double x) { return std::exp(x); };
  this->expect_at_most(1.0, "exp", worst_ulps<T>(T(-80), T(80), exp<T>, judged));
}

TYPED_TEST(MathsAccuracy, OfWrappedAngles) {
  using T = TypeParam;
  constexpr long double kPiLong = 3.14159265358979323846264338327950288L;
  double worst = 0.0;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1e5, 1e5);
  for (int i = 0; i < kArguments; ++i) {
    const T angle = static_cast<T>(uniform(random));
    const T wrapped = wrap_pi(angle);
    ASSERT_GT(wrapped, -static_cast<T>(kPi)) << angle;
    ASSERT_LE(wrapped, static_cast<T>(kPi)) << angle;
    // The C library's sine and cosine reduce their argument exactly, whatever its size.
    const auto given = static_cast<long double>(angle);
    const long double exact = std::atan2(std::sin(given), std::cos(given));
    const long double apart = std::fabs(static_cast<long double>(wrapped) - exact);
    worst = std::max(worst, static_cast<double>(std::min(apart, std::fabs(apart - 2 * kPiLong))));
  }
  // In units of the last place of pi, because a wrapped angle near zero has the absolute error of the reduction.
  const double of_pi = worst / std::ldexp(1.0, 2 - std::numeric_limits<T>::digits);
  this->expect_at_most(1.0, "wrap_pi (ulp of pi)", of_pi);
}

}  // namespace
}  // namespace m100::core
