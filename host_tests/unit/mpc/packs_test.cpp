// SPDX-License-Identifier: BSD-3-Clause
// Every operation of a pack works lane by lane. Flights and programs use the copy for the widest registers of this
// machine; this test runs the copy for machines without them.
#include "firmware/mpc/packs.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace m100::mpc::M100_LANES_NAMESPACE {
namespace {

template <typename T>
class Packs : public ::testing::Test {
 protected:
  using Lanes = std::array<T, kLanes>;
  static Lanes some(T first, T step) {
    Lanes lanes{};
    for (std::size_t i = 0; i < kLanes; ++i) {
      lanes[i] = first + step * static_cast<T>(i * i);
    }
    return lanes;
  }
  static Lanes lanes_of(const Pack<T>& pack) {
    Lanes lanes{};
    store<T>(lanes.data(), pack);
    return lanes;
  }
  template <typename Operation>
  void expect_lanewise(const Pack<T>& result, const Operation& operation) const {
    for (std::size_t i = 0; i < kLanes; ++i) {
      EXPECT_EQ(lanes_of(result)[i], operation(a_[i], b_[i])) << "lane " << i;
    }
  }
  template <typename Comparison>
  static void expect_bits(const Mask<T>& mask, const Lanes& a, const Lanes& b, const Comparison& holds) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
      bits |= holds(a[i], b[i]) ? 1U << i : 0U;
    }
    EXPECT_EQ(bits_of<T>(mask), bits);
  }

  const Lanes a_ = some(T(1.5), T(0.75));
  const Lanes b_ = some(T(3.25), T(-0.5));
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Packs, Scalars);

TYPED_TEST(Packs, ComputeLaneByLane) {
  using T = TypeParam;
  const Pack<T> a = load(this->a_.data());
  const Pack<T> b = load(this->b_.data());
  this->expect_lanewise(a + b, [](T x, T y) { return x + y; });
  this->expect_lanewise(a - b, [](T x, T y) { return x - y; });
  this->expect_lanewise(a * b, [](T x, T y) { return x * y; });
  this->expect_lanewise(-a, [](T x, T) { return -x; });
  this->expect_lanewise(larger<T>(a, b), [](T x, T y) { return x > y ? x : y; });
  this->expect_lanewise(smaller<T>(a, b), [](T x, T y) { return x < y ? x : y; });
  this->expect_lanewise(spread(T(7)), [](T, T) { return T(7); });
  this->expect_lanewise(choose<T>(is_below<T>(a, b), a, b), [](T x, T y) { return x < y ? x : y; });
}

// Each lane is once less, once equal, once greater and once NaN.
TYPED_TEST(Packs, CompareLaneByLane) {
  using T = TypeParam;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    for (const T other : {T(1), T(2), T(3), std::numeric_limits<T>::quiet_NaN()}) {
      auto x = this->some(T(2), T(0)), y = x;
      y[lane] = other;
      const Pack<T> a = load(x.data());
      const Pack<T> b = load(y.data());
      this->expect_bits(is_below<T>(a, b), x, y, [](T p, T q) { return p < q; });
      this->expect_bits(is_at_most<T>(a, b), x, y, [](T p, T q) { return p <= q; });
      this->expect_bits(is_equal<T>(a, b), x, y, [](T p, T q) { return p == q; });
    }
  }
}

TYPED_TEST(Packs, TheLargestLaneIsFoundWhereverItIs) {
  using T = TypeParam;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    auto lanes = this->some(T(-9), T(0));
    lanes[lane] = T(-2);
    EXPECT_EQ(largest_of<T>(load(lanes.data())), T(-2)) << lane;
  }
}

#ifndef M100_LANES_SCALAR
TYPED_TEST(Packs, SumsAreThoseOfTheLanes) {
  using T = TypeParam;
  const Pack<T> a = load(this->a_.data());
  const Pack<T> b = load(this->b_.data());
  const auto sums = this->lanes_of(sums_of<T>(a, b, a - b, a * b));
  const auto sum = [&](const Pack<T>& pack) {
    const auto lanes = this->lanes_of(pack);
    return (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
  };
  EXPECT_EQ(sums[0], sum(a));
  EXPECT_EQ(sums[1], sum(b));
  EXPECT_EQ(sums[2], sum(a - b));
  EXPECT_EQ(sums[3], sum(a * b));
}
#endif

}  // namespace
}  // namespace m100::mpc::M100_LANES_NAMESPACE
