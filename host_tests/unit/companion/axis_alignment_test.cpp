// SPDX-License-Identifier: BSD-3-Clause
// An aircraft is moved by hand while the axes of its pose are right, turned, exchanged or mirrored; the check must name
// the error.
#include "firmware/companion/preflight/axis_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <map>
#include <string>

namespace m100::companion::preflight {
namespace {

using Vector = Eigen::Vector3d;
using Rotation = Eigen::Quaterniond;

/// True motion of the aircraft: tilted, turned and moved, one after the other, as the operator is asked to do.
struct Hand {
  Vector position = Vector::Zero(), acceleration = Vector::Zero();
  Rotation wb = Rotation::Identity();
};
constexpr double kSwing_s = 1.2;  ///< one full swing

Hand hand_at(double t_s) {
  Hand hand;
  if (t_s < 0.0) {
    return hand;  // at rest
  }
  const int phase = static_cast<int>(t_s / 5.0);
  const double w = 2.0 * core::kPi / kSwing_s;
  const double swing = std::sin(w * t_s);
  const auto about = [&](const Vector& axis, double angle) { return Rotation(Eigen::AngleAxisd(angle * swing, axis)); };
  hand.wb = phase == 0   ? about(Vector::UnitY(), 0.35)
            : phase == 1 ? about(Vector::UnitX(), 0.35)
            : phase == 2 ? about(Vector::UnitZ(), 0.8)
                         : Rotation::Identity();
  if (phase >= 3 && phase < 6) {
    const Vector axis = Vector::Unit(phase - 3);
    hand.position = 0.15 * swing * axis;
    hand.acceleration = -0.15 * w * w * swing * axis;
  }
  return hand;
}

core::Quaternion<double> quaternion(const Rotation& r) { return {r.w(), r.x(), r.y(), r.z()}; }

struct Seen {
  Vector position;
  Rotation wb;
};
using Error = std::function<Seen(const Seen&)>;

/// The checks by name, after `length_s` of motion.
/// @param late_s how much the pose is later than the autopilot's data.
/// @param north_rad angle from the room's frame to the autopilot's world. @param bias_b_m_s2 of the force.
/// @param rest_s before the motion.
std::map<std::string, CheckResult> moved(const Error& error, double length_s = 30.0, double late_s = 0.02,
                                         double unit = 1.0, double north_rad = 2.1,
                                         const Vector& bias_b_m_s2 = Vector::Zero(), double rest_s = -0.1) {
  AxisAlignment frames;
  const Rotation north(Eigen::AngleAxisd(north_rad, Vector::UnitZ()));
  for (double t_s = -rest_s; t_s < length_s; t_s += 0.01) {
    const Hand now = hand_at(t_s), then = hand_at(t_s - late_s);
    const Seen seen = error({then.position, then.wb});
    AxisAlignment::Sample sample;
    sample.position_w_m = seen.position;
    sample.pose_wb = quaternion(seen.wb);
    sample.autopilot_wb = quaternion(north * now.wb);
    sample.force_b = unit * (now.wb.conjugate() * (now.acceleration + Vector(0.0, 0.0, 9.80665)) + bias_b_m_s2);
    frames.add(sample);
  }
  std::map<std::string, CheckResult> out;
  for (const CheckResult& check : frames.checks()) {
    out[check.name] = check;
  }
  return out;
}

std::string bad_ones(const std::map<std::string, CheckResult>& checks) {
  std::string out;
  for (const auto& [name, check] : checks) {
    if (check.health != Health::kGood) {
      out += name + ": " + check.finding.substr(0, check.finding.find(" (")) + "; ";
    }
  }
  return out;
}

TEST(AxisAlignment, RightAxesAreRight) {
  EXPECT_EQ(bad_ones(moved([](const Seen& seen) { return seen; })), "");
}

// Would catch a force that is rotated wrongly into the world. The room's x may point anywhere, also exactly north.
TEST(AxisAlignment, WhereverNorthLiesRightAxesAreRight) {
  for (const double north_rad : {-3.1, -1.6, -0.02, 0.0, 0.02, 0.8, 1.5707963, 3.1}) {
    EXPECT_EQ(bad_ones(moved([](const Seen& seen) { return seen; }, 30.0, 0.02, 1.0, north_rad)), "") << north_rad;
    const auto mirrored = [](const Seen& seen) {
      return Seen{Vector(seen.position.x(), -seen.position.y(), seen.position.z()), seen.wb};
    };
    EXPECT_EQ(bad_ones(moved(mirrored, 30.0, 0.02, 1.0, north_rad)), "position y: is reversed; ") << north_rad;
  }
}

TEST(AxisAlignment, AnAutopilotThatTellsItsForceInGIsUnderstood) {
  EXPECT_EQ(bad_ones(moved([](const Seen& seen) { return seen; }, 30.0, 0.02, 1.0 / 9.80665)), "");
}

// Some sources report a heading but no tilt; m100 uses the heading only.
TEST(AxisAlignment, ATiltThatIsNotSentIsNoWrongAxis) {
  const std::map<std::string, CheckResult> checks = moved([](const Seen& seen) {
    const double yaw = std::atan2((seen.wb * Vector::UnitX()).y(), (seen.wb * Vector::UnitX()).x());
    return Seen{seen.position, Rotation(Eigen::AngleAxisd(yaw, Vector::UnitZ()))};
  });
  EXPECT_EQ(checks.at("roll").health, Health::kDoubtful) << checks.at("roll").finding;
  EXPECT_EQ(checks.at("pitch").health, Health::kDoubtful) << checks.at("pitch").finding;
  EXPECT_EQ(checks.at("heading").health, Health::kGood) << checks.at("heading").finding;
}

TEST(AxisAlignment, AnotherHeadingOfTheBodyIsNoError) {  // the markers define the room's x
  const Rotation room(Eigen::AngleAxisd(-0.7, Vector::UnitZ()));
  EXPECT_EQ(bad_ones(moved([&](const Seen& seen) { return Seen{room * seen.position, room * seen.wb}; })), "");
}

TEST(AxisAlignment, EachReversedOrExchangedAxisIsNamed) {
  const auto at = [](Vector (*change)(const Vector&)) {
    return moved([change](const Seen& seen) { return Seen{change(seen.position), seen.wb}; });
  };
  EXPECT_EQ(bad_ones(at([](const Vector& p) { return Vector(-p.x(), p.y(), p.z()); })), "position x: is reversed; ");
  EXPECT_EQ(bad_ones(at([](const Vector& p) { return Vector(p.x(), -p.y(), p.z()); })), "position y: is reversed; ");
  EXPECT_EQ(bad_ones(at([](const Vector& p) { return Vector(p.x(), p.y(), -p.z()); })), "position z: is reversed; ");
  EXPECT_EQ(bad_ones(at([](const Vector& p) { return Vector(p.y(), p.x(), p.z()); })),
            "position x: is the autopilot's y; position y: is the autopilot's x; ");
  EXPECT_EQ(bad_ones(at([](const Vector& p) { return Vector(p.z(), p.x(), p.y()); })),
            "position x: is the autopilot's z; position y: is the autopilot's x; position z: is the autopilot's y; ");
}

TEST(AxisAlignment, AReversedRollPitchOrHeadingIsNamed) {
  const auto with = [](Rotation (*change)(const Rotation&)) {
    return moved([change](const Seen& seen) { return Seen{seen.position, change(seen.wb)}; });
  };
  // x and y of the quaternion belong to roll and pitch, z to the heading.
  EXPECT_EQ(bad_ones(with([](const Rotation& q) { return Rotation(q.w(), -q.x(), q.y(), q.z()); })),
            "roll: is reversed; ");
  EXPECT_EQ(bad_ones(with([](const Rotation& q) { return Rotation(q.w(), q.x(), -q.y(), q.z()); })),
            "pitch: is reversed; ");
  EXPECT_EQ(bad_ones(with([](const Rotation& q) { return Rotation(q.w(), q.x(), q.y(), -q.z()); })),
            "heading: is reversed; ");
  EXPECT_EQ(bad_ones(with([](const Rotation& q) { return Rotation(q.w(), q.y(), q.x(), q.z()); })).substr(0, 32),
            "pitch: is the autopilot's roll; ");
}

// Catches a lever of the wrong sign or axes, one that the sensor's offset makes, and a proposal without a turn.
TEST(AxisAlignment, ALeverArmIsFoundByATurnAndByNothingElse) {
  const Vector bias_b_m_s2(0.1, -0.08, 0.05);
  const auto lever_arm = [&](const Vector& lever_b_m, double length_s, double false_m = 0.0) {
    double t_s = 0.0;
    const auto beside = [&](const Seen& seen) {
      t_s += 0.01;
      return Seen{seen.position + seen.wb * lever_b_m + false_m * std::sin(4.0 * t_s) * Vector::UnitX(), seen.wb};
    };
    std::map<std::string, CheckResult> checks = moved(beside, length_s, 0.02, 1.0, 2.1, bias_b_m_s2, 4.0);
    EXPECT_EQ(checks.count("lever arm"), 1U) << bad_ones(checks);
    return checks["lever arm"];
  };
  for (const Vector& lever_b_m :
       {Vector(0.2, 0.0, 0.0), Vector(0.0, -0.3, 0.1), Vector(-0.15, 0.1, -0.1), Vector(0.1, 0.0, 0.0)}) {
    const CheckResult turned = lever_arm(lever_b_m, 16.0);
    double x_m = 0.0, y_m = 0.0;
    const std::size_t at = turned.remedy.find("offset_m = [");
    ASSERT_NE(at, std::string::npos) << turned.finding;
    ASSERT_EQ(std::sscanf(turned.remedy.c_str() + at, "offset_m = [%lf, %lf, Z]", &x_m, &y_m), 2) << turned.remedy;
    EXPECT_LE(std::hypot(x_m - lever_b_m.x(), y_m - lever_b_m.y()), 0.25 * lever_b_m.norm()) << turned.finding;
    EXPECT_EQ(lever_arm(lever_b_m, 9.9).finding, "not turned enough to tell");
  }
  EXPECT_EQ(lever_arm(Vector::Zero(), 30.0).health, Health::kGood) << lever_arm(Vector::Zero(), 30.0).finding;
  EXPECT_EQ(lever_arm(Vector::Zero(), 14.9, 0.15).finding.find("cannot tell"), 0U)
      << lever_arm(Vector::Zero(), 14.9, 0.15).finding;
}

TEST(AxisAlignment, WhatWasNotMovedIsNotJudged) {
  const std::map<std::string, CheckResult> checks = moved([](const Seen& seen) { return seen; }, 4.9);
  EXPECT_EQ(checks.at("pitch").health, Health::kGood);
  for (const char* const name : {"roll", "heading", "position x", "position y", "position z"}) {
    EXPECT_EQ(checks.at(name).health, Health::kDoubtful) << name << ": " << checks.at(name).finding;
    EXPECT_FALSE(checks.at(name).remedy.empty());
  }
}

}  // namespace
}  // namespace m100::companion::preflight
