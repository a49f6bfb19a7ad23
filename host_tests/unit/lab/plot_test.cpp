// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {
namespace {

// Catches thinning that keeps every n-th point: it loses the spike that the reader looks for.
TEST(Plot, ThinningKeepsASpikeOfOneSample) {
  Curve line{.name = "y", .x = {}, .y = {}};
  for (int i = 0; i < 50000; ++i) {
    line.x.push_back(i);
    line.y.push_back(i == 31415 ? 10.0 : 0.0);
  }
  const Figure figure{
      .title = "t", .x_label = "x", .y_label = "y", .lines = {line}, .y_range = {{0.0, 10.0}}, .height = 280};
  EXPECT_NE(svg(figure).find(" 46.0"), std::string::npos);  // the upper edge of the sheet
}

TEST(Plot, NanBreaksACurveInsteadOfDrawingIt) {
  const Curve line{.name = "", .x = {0, 1, 2, 3}, .y = {1, std::nan(""), 1, 2}};
  const std::string picture = svg(Figure{.title = "t", .x_label = "", .y_label = "", .lines = {line}});
  EXPECT_EQ(picture.find("nan"), std::string::npos);
}

TEST(Plot, WordsOfTheUserCannotBreakThePage) {
  Page page("a < b & \"c\"");
  page.paragraph("<script>");
  EXPECT_EQ(page.html().find("<script>"), std::string::npos);
  EXPECT_NE(page.html().find("a &lt; b &amp; &quot;c&quot;"), std::string::npos);
}

struct NumberCase {
  const char* name;
  double value;
  const char* text;
};
class Number : public ::testing::TestWithParam<NumberCase> {};
TEST_P(Number, IsWrittenForPeople) { EXPECT_EQ(number(GetParam().value), GetParam().text); }
INSTANTIATE_TEST_SUITE_P(Table, Number,
                         ::testing::Values(NumberCase{"Zero", 0.0, "0"}, NumberCase{"Small", 0.0072, "0.00720"},
                                           NumberCase{"Tiny", 8.65e-4, "8.65e-04"}, NumberCase{"Large", 123.4, "123"},
                                           NumberCase{"Missing", std::nan(""), "–"}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::lab::plot
