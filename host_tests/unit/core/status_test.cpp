// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/status.h"

#include <gtest/gtest.h>

#include <set>
#include <string_view>

#include "firmware/core/time.h"

namespace m100::core {
namespace {

// Catches two status codes with the same name, and a new code without a name.
TEST(StatusName, IsAnotherWordForEachReason) {
  std::set<std::string_view> words;
  for (auto k = static_cast<unsigned char>(Status::kOk); k <= static_cast<unsigned char>(Status::kNotConverged); ++k) {
    const std::string_view word = name(static_cast<Status>(k));
    EXPECT_NE(word, "unknown") << int{k};
    EXPECT_TRUE(words.insert(word).second) << word;
  }
  EXPECT_EQ(name(Status::kOk), "ok");
  EXPECT_EQ(name(Status::kNotConverged), "not converged");
  EXPECT_EQ(name(static_cast<Status>(200)), "unknown") << "a byte of a damaged log";
}

// Catches a count of microseconds that is truncated to 32 bits, which end after 35 minutes and 47 seconds.
TEST(Seconds, GoOnBeyondHalfAnHour) {
  using std::chrono::microseconds;
  EXPECT_EQ(seconds<double>(std::chrono::hours(1)), 3600.0);
  EXPECT_EQ(seconds<float>(-std::chrono::hours(1)), -3600.F);
  for (const std::int64_t edge_us : {0x7FFFFFFFLL, 0x80000000LL, -0x80000000LL, -0x80000001LL}) {
    EXPECT_EQ(seconds<double>(microseconds(edge_us)), static_cast<double>(edge_us) / 1e6);
  }
}

}  // namespace
}  // namespace m100::core
