// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/pose_wire.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <sstream>
#include <string>

namespace m100::mavlink {
namespace {

constexpr std::array kBauds{57600.0, 115200.0, 230400.0, 460800.0, 921600.0};

/// A share in per cent, in brackets if doctor refuses it.
std::string cell(double share) {
  const std::string percent = std::to_string(std::lround(100.0 * share));
  return share > kMaxPoseShare ? " (" + percent + " %) |" : " " + percent + " % |";
}

// The table of the README: each message at each baud rate, unsigned and signed; shares that doctor refuses are in
// brackets.
TEST(PoseWire, WhatAPoseTakesOfALine) {
  std::ostringstream table;
  table << "\n| message | bytes | 57600 | 115200 | 230400 | 460800 | 921600 |\n|---|---|---|---|---|---|---|\n";
  for (const std::size_t more : {std::size_t{0}, kSignatureBytes}) {
    for (PoseWire wire : kPoseWires) {
      wire.bytes += more;
      table << "| " << wire.name << (more > 0 ? ", signed" : "") << " | " << wire.bytes << " |";
      for (const double baud : kBauds) {
        table << cell(line_share(wire, 100.0, baud));
      }
      table << "\n";
    }
  }
  EXPECT_NE(table.str().find("| ATT_POS_MOCAP | 48 | (83 %) | 42 % |"), std::string::npos) << table.str();
  RecordProperty("figure.pose_wire", table.str());
}

// Ten bits per byte: 48 bytes, 100 times a second, are 48 000 bits.
TEST(PoseWire, AShareIsBitsOverBaud) {
  EXPECT_DOUBLE_EQ(line_share({"x", 48}, 100.0, 48000.0), 1.0);
  EXPECT_DOUBLE_EQ(line_share({"x", 48}, 50.0, 96000.0), 0.25);
}

}  // namespace
}  // namespace m100::mavlink
