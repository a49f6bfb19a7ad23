// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/pose_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace m100::mavlink {
namespace {

// Would catch a table for people that the program does not keep to: each row of the README is worked out again.
TEST(PoseWire, TheReadmesTableIsWhatTheProgramReckonsWith) {
  std::ifstream file("protocol/mavlink/README.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_FALSE(text.empty());
  for (const PoseWire& wire : kPoseWires) {
    std::ostringstream row;
    row << "| " << wire.name << " | " << wire.bytes << " |";
    for (const double baud : {57600.0, 115200.0, 230400.0, 460800.0, 921600.0}) {
      row << " " << std::lround(100.0 * line_share(wire, 100.0, baud)) << " % |";
    }
    EXPECT_NE(text.find(row.str()), std::string::npos) << row.str();
  }
}

}  // namespace
}  // namespace m100::mavlink
