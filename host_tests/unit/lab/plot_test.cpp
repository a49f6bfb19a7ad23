// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/live.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::plot {
namespace {

// Catches thinning that keeps every n-th point: it loses the spike that the reader looks for.
TEST(Plot, ThinningKeepsASpikeOfOneSample) {
  Curve line{.name = "y"};
  for (int i = 0; i < 50000; ++i) {
    line.x.push_back(i);
    line.y.push_back(i == 31415 ? 10.0 : 0.0);
  }
  const Figure figure{
      .title = "t", .x_label = "x", .y_label = "y", .lines = {line}, .y_range = {{0.0, 10.0}}, .height = 280};
  EXPECT_NE(svg(figure).find(" 46.0"), std::string::npos);  // the upper edge of the sheet
}

// Also of one point, of an axis whose values are all alike, and of a range without a width.
TEST(Plot, NoCoordinateIsNan) {
  for (const Curve& line : {Curve{.name = "", .x = {0, 1, 2, 3}, .y = {1, std::nan(""), 1, 2}},
                            Curve{.name = "", .x = {7}, .y = {0}}, Curve{.name = "", .x = {7, 7}, .y = {1, 2}}}) {
    for (const Figure& figure :
         {Figure{.title = "t", .x_label = "", .y_label = "", .lines = {line}},
          Figure{.title = "t", .x_label = "", .y_label = "", .lines = {line}, .y_range = {{0, 0}}},
          Figure{.title = "t", .x_label = "", .y_label = "", .lines = {line}, .equal_axes = true}}) {
      EXPECT_EQ(svg(figure).find("nan"), std::string::npos);
    }
  }
}

// One tick does not show the scale: the height of a course in 180 pixels had 0.0 alone.
TEST(Plot, ALowFigureHasTwoTicks) {
  for (const double height : {0.41, 0.6, 0.99, 1.7, 2.4}) {
    const std::string drawn = svg({.title = "",
                                   .x_label = "",
                                   .y_label = "",
                                   .lines = {{.name = "", .x = {0, 1}, .y = {0, height}}},
                                   .height = 140});
    std::size_t ticks = 0;
    for (std::size_t at = 0; (at = drawn.find("text-anchor=\"end\"", at)) != std::string::npos; ++at) {
      ++ticks;
    }
    EXPECT_GE(ticks, 2U) << height << '\n' << drawn;
  }
}

TEST(Plot, WordsOfTheUserCannotBreakThePage) {
  Page page("a < b & \"c\"");
  page.paragraph("<script> -> b");
  EXPECT_EQ(page.html().find("<script>"), std::string::npos);
  EXPECT_NE(page.html().find("&lt;script&gt; → b"), std::string::npos);
  EXPECT_NE(page.html().find("a &lt; b &amp; &quot;c&quot;"), std::string::npos);
}

// Ranges of a log may come in any order (--split alternate): no line may run back from one to the other.
TEST(Plot, TimeThatRunsBackBetweenRangesIsPutInOrder) {
  const Curve line{.name = "y", .x = {0, 1, 4, 5, 2, 3, 8}, .y = {0, 1, 4, 5, 2, 3, 8}, .max_step = 1.5};
  const Curve found = in_order(line);
  EXPECT_TRUE(std::is_sorted(found.x.begin(), found.x.end()));
  ASSERT_EQ(found.x.size(), 8U) << "seven points and the break of the gap from 5 to 8";
  for (std::size_t i = 0; i < found.x.size(); ++i) {
    EXPECT_TRUE(std::isnan(found.y[i]) || found.y[i] == found.x[i]) << i;
  }
  EXPECT_TRUE(std::isnan(found.y[6]));
  const std::string data = live_data(Figure{.title = "t", .x_label = "", .y_label = "", .lines = {line}});
  EXPECT_NE(data.find("\"x\":[0,1,2,3,4,5,5,8]"), std::string::npos) << data;
  EXPECT_NE(data.find("\"y\":[0,1,2,3,4,5,null,8]"), std::string::npos) << data;
}

TEST(Plot, DataOfALiveFigureCannotEndItsElement) {
  const Figure figure{.title = "t", .x_label = "</script>", .y_label = "", .lines = {}};
  EXPECT_EQ(live_data(figure).find("</"), std::string::npos);
}

TEST(Plot, AHeatMapSaysWhatItsColoursMean) {
  const std::string map = html(HeatMap{.title = "t",
                                       .rows = {"r"},
                                       .columns = {"c", "d"},
                                       .values = {{1.0, std::nan("")}},
                                       .words = {{"10 of 10", ""}},
                                       .good = 0.02,
                                       .bad = 1.0});
  EXPECT_NE(map.find("<span>1.00</span><i></i><span>0.0200</span>"), std::string::npos) << map;
  EXPECT_NE(map.find("<td class=\"none\"></td>"), std::string::npos);
}

TEST(Plot, AChangeInPerCentHasASignAndNoMinusZero) {
  EXPECT_EQ(percent(-0.0001), "0 %");
  EXPECT_EQ(percent(0.123), "+12 %");
  EXPECT_EQ(percent(-0.034), "-3.4 %");
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
