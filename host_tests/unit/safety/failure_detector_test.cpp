// SPDX-License-Identifier: BSD-3-Clause
// States that end a flight at once (promise R18): tilt, tumbling, free fall, crash, and the ground. Each is tested from
// both sides of its bound, and with the sensor fault that looks like it.
#include "firmware/safety/failure_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/core/maths.h"
#include "firmware/safety/ground_contact.h"

namespace m100::safety {
namespace {

using Vector3 = core::Vector<double, 3>;
constexpr double kStep_s = 0.01;
constexpr double kDegree = core::kPi / 180.0;

/// The vertical in body axes after a turn by `tilt_rad` about an axis of the body's plane, 0: roll.
Vector3 up_at(double tilt_rad, double axis_rad = 0.0) {
  return {-std::sin(tilt_rad) * std::sin(axis_rad), std::sin(tilt_rad) * std::cos(axis_rad), std::cos(tilt_rad)};
}

class FailureDetectorTest : public ::testing::Test {
 protected:
  /// Rolls from rest to `roll_rad` at `rate_rad_s`, then holds it. @returns the first failure
  FlightFailure roll(double roll_rad, double rate_rad_s, double hold_s) {
    for (double t_s = 0.0; t_s * rate_rad_s < roll_rad; t_s += kStep_s) {
      fly(t_s * rate_rad_s, rate_rad_s);
    }
    return hold(roll_rad, hold_s);
  }
  FlightFailure hold(double roll_rad, double hold_s) {
    for (double t_s = 0.0; t_s < hold_s - 1e-9; t_s += kStep_s) {
      fly(roll_rad, 0.0);
    }
    return first_;
  }
  /// @returns the ticks at this angle until the first failure; 999: it names none
  int ticks_to(FlightFailure failure, double roll_rad) {
    int ticks = 0;
    for (; first_ == FlightFailure::kNone && ticks < 999; ++ticks) {
      fly(roll_rad, 0.0);
    }
    EXPECT_EQ(first_, ticks == 999 ? FlightFailure::kNone : failure);
    return ticks;
  }
  void fly(double roll_rad, double rate_rad_s) {
    sample_.up_b = up_at(roll_rad, axis_rad_);
    sample_.rate_b_rad_s = {rate_rad_s * std::cos(axis_rad_), rate_rad_s * std::sin(axis_rad_), yaw_rate_rad_s_};
    axis_rad_ -= yaw_rate_rad_s_ * kStep_s;
    const FlightFailure now = detector_.update(sample_, kStep_s);
    first_ = first_ == FlightFailure::kNone ? now : first_;
  }

  FailureDetector<double> detector_;
  FlightSample<double> sample_{.force_g = 1.0, .climb_m_s = 0.01};
  FlightFailure first_ = FlightFailure::kNone;
  double axis_rad_ = 0.0;        ///< of the turn, in the body's plane
  double yaw_rate_rad_s_ = 0.0;  ///< turns that axis
};

TEST_F(FailureDetectorTest, ATiltBeyond45Degrees) {
  RecordProperty("promise", "R18");
  EXPECT_EQ(roll(44.0 * kDegree, 3.0, 5.0), FlightFailure::kNone);
  detector_ = {};
  roll(45.2 * kDegree, 1.0, 0.0);
  EXPECT_EQ(ticks_to(FlightFailure::kTilt, 46.0 * kDegree), 11) << "after 0.1 s";
}

// Catches a rate about one of the axes that turns the vertical the wrong way or too little: the tilt would be believed
// up to half a second later. Beyond 45 degrees every axis is like the others.
TEST_F(FailureDetectorTest, ATiltAboutAnyAxisAndWhileItTurns) {
  for (const double axis_rad : {0.0, 1.57, -1.0, 2.5}) {
    for (const double yaw_rate_rad_s : {0.0, 4.0, -4.0}) {
      detector_ = {};
      first_ = FlightFailure::kNone;
      axis_rad_ = axis_rad;
      yaw_rate_rad_s_ = 0.0;
      EXPECT_EQ(roll(43.0 * kDegree, 5.0, 0.0), FlightFailure::kNone);
      yaw_rate_rad_s_ = yaw_rate_rad_s;
      EXPECT_EQ(hold(43.0 * kDegree, 0.3), FlightFailure::kNone);
      int ticks = 0;
      while (first_ == FlightFailure::kNone && ticks < 99) {
        ++ticks;
        fly(43.0 * kDegree + 5.0 * kStep_s * ticks, 5.0);
      }
      EXPECT_EQ(first_, FlightFailure::kTilt);
      EXPECT_NEAR(ticks, 11, 1) << axis_rad << " " << yaw_rate_rad_s << ": after 0.1 s";
    }
  }
}

TEST_F(FailureDetectorTest, ATiltThatTheRatesContradictIsJudgedHalfASecondLater) {
  RecordProperty("promise", "R14");
  sample_.attitude_is_trusted = false;
  EXPECT_EQ(hold(80.0 * kDegree, 5.0), FlightFailure::kNone);
  hold(0.0, 5.0);
  sample_.attitude_is_trusted = true;
  EXPECT_EQ(ticks_to(FlightFailure::kTilt, 80.0 * kDegree), 59) << "the rates have not shown it";
}

TEST_F(FailureDetectorTest, Tumbling) {
  RecordProperty("promise", "R18");
  for (const auto& [roll_rad_s, rate_rad_s] : {std::pair{0.0, 2.0 * core::kPi}, {0.0, 6.4}, {6.4, 0.0}}) {
    FailureDetector<double> detector;
    FlightFailure failure = FlightFailure::kNone;
    for (int tick = 0; tick < 26; ++tick) {
      sample_.up_b = up_at(0.0);
      sample_.rate_b_rad_s = {roll_rad_s, 0.0, rate_rad_s};  // a roll of a level aircraft has another unit
      failure = detector.update(sample_, kStep_s);
      EXPECT_TRUE(tick > 23 || failure == FlightFailure::kNone) << "for less than 0.25 s";
    }
    EXPECT_EQ(failure, rate_rad_s > 2.0 * core::kPi ? FlightFailure::kTumbling : FlightFailure::kNone);
  }
}

TEST_F(FailureDetectorTest, AFreeFall) {
  RecordProperty("promise", "R18");
  hold(0.0, 1.0);
  sample_.force_g = 0.19;
  sample_.climb_m_s = -0.5 * 9.8066 * 0.3;
  EXPECT_EQ(hold(0.0, 1.0), FlightFailure::kNone) << "the climb speed does not show it";
  sample_.climb_m_s = -1.55;
  EXPECT_EQ(ticks_to(FlightFailure::kFreeFall, 0.0), 1);
}

TEST_F(FailureDetectorTest, APushOverOrASagIsNoFreeFall) {
  RecordProperty("promise", "R17");
  sample_.climb_m_s = -3.0;
  sample_.force_g = 0.2;
  EXPECT_EQ(hold(0.0, 2.0), FlightFailure::kNone);
  sample_.force_g = 0.19;
  EXPECT_NEAR(ticks_to(FlightFailure::kFreeFall, 0.0), 30, 1);
}

TEST_F(FailureDetectorTest, AnAircraftWhoseTiltIsFarFromItsCommand) {
  RecordProperty("promise", "R18");
  sample_.lean_rad = core::kPi / 6.0;
  EXPECT_EQ(hold(20.0 * kDegree, 5.0), FlightFailure::kNone);
  sample_.lean_rad = 31.0 * kDegree;
  EXPECT_EQ(hold(20.0 * kDegree, 1.98), FlightFailure::kNone) << "for less than 2 s";
  EXPECT_EQ(hold(20.0 * kDegree, 0.05), FlightFailure::kCrash);
}

// A blow, some seconds of motion, and then none: turns of 0.1 rad/s or a climb of 0.1 m/s are motion.
TEST_F(FailureDetectorTest, AShockAndThenNoMotion) {
  RecordProperty("promise", "R17, R18");
  struct Case {
    double shock_g, moving_s, rate_rad_s, climb_m_s, still_rad_s, still_m_s;
    int ticks;
  };
  for (const Case& one : {Case{3.05, 0.0, 0.0, 0.0, 0.095, 0.095, 100}, Case{3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 999},
                          Case{3.05, 1.9, 0.1, 0.0, 0.0, -0.095, 100}, Case{3.05, 2.1, 0.1, 0.0, 0.0, 0.0, 999},
                          Case{3.05, 1.9, 0.0, 0.1, 0.0, 0.0, 100}, Case{3.05, 2.1, 0.0, -0.1, 0.0, 0.0, 999}}) {
    detector_ = {};
    first_ = FlightFailure::kNone;
    sample_.climb_m_s = 0.01;
    hold(0.0, 1.0);
    sample_.force_g = one.shock_g;
    hold(0.0, 0.02);
    sample_.force_g = 1.0;
    sample_.climb_m_s = one.climb_m_s;
    for (double t_s = 0.0; t_s < one.moving_s - 1e-9; t_s += kStep_s) {
      fly(0.0, one.rate_rad_s);
    }
    sample_.climb_m_s = one.still_m_s;
    int ticks = 0;
    for (; first_ == FlightFailure::kNone && ticks < 999; ++ticks) {
      fly(0.0, one.still_rad_s);
    }
    EXPECT_NEAR(ticks, one.ticks, 1) << one.shock_g << " " << one.moving_s;
    EXPECT_EQ(first_, ticks < 999 ? FlightFailure::kCrash : FlightFailure::kNone);
  }
}

// A vibration that begins in a still hover is no crash, however often it exceeds 3 g; a blow with rest after it is one.
TEST_F(FailureDetectorTest, AVibrationIsNoCrashAndABlowBeyondItIsOne) {
  RecordProperty("promise", "R17, R18");
  for (const double sigma_g : {0.1, 0.3, 0.5, 0.8, 1.2}) {
    detector_ = {};
    first_ = FlightFailure::kNone;
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, sigma_g);
    double largest_g = 0.0;
    for (double t_s = 0.0; t_s < 120.0; t_s += kStep_s) {
      sample_.force_g = Vector3(noise(random), noise(random), 1.0 + noise(random)).norm();
      largest_g = std::max(largest_g, *sample_.force_g);
      fly(0.0, 0.0);
    }
    EXPECT_EQ(first_, FlightFailure::kNone) << sigma_g;
    sample_.force_g = std::max(4.0, 2.5 * largest_g);
    fly(0.0, 0.0);
    sample_.force_g = 1.0;
    EXPECT_EQ(hold(0.0, 1.5), FlightFailure::kCrash) << sigma_g;
  }
}

// An aircraft that hits something again and again for a while, and then lies still while its rotors shake it.
TEST_F(FailureDetectorTest, BlowsThatLastAreACrash) {
  RecordProperty("promise", "R18");
  std::mt19937 random(3);
  for (const double largest_g : {4.0, 6.0, 8.0}) {
    for (const double lasts_s : {0.1, 0.4, 1.0}) {
      detector_ = {};
      first_ = FlightFailure::kNone;
      std::uniform_real_distribution<double> blow(0.5 * largest_g, largest_g);
      std::normal_distribution<double> shakes(1.0, 0.2);
      for (double t_s = 0.0; t_s < lasts_s; t_s += kStep_s) {
        sample_.force_g = blow(random);
        fly(0.0, 0.0);
      }
      for (double t_s = 0.0; t_s < 1.5; t_s += kStep_s) {
        sample_.force_g = shakes(random);
        fly(0.0, 0.0);
      }
      EXPECT_EQ(first_, FlightFailure::kCrash) << largest_g << " g for " << lasts_s << " s";
    }
  }
}

TEST_F(FailureDetectorTest, NumbersThatAreNoneLeaveNoTrace) {
  fly(std::nan(""), std::nan(""));
  first_ = FlightFailure::kNone;
  EXPECT_EQ(hold(0.0, 1.0), FlightFailure::kNone);
  EXPECT_EQ(roll(50.0 * kDegree, 3.0, 0.5), FlightFailure::kTilt);
}

TEST(GroundContact, CountsFromTheLastStatusInTheAir) {
  RecordProperty("promise", "R18");
  const auto at = [](int milliseconds) { return core::TimePoint(std::chrono::milliseconds(milliseconds)); };
  GroundContact contact;
  contact.update(true, false, at(100));
  contact.update(true, false, at(900));
  EXPECT_EQ(contact.duration(), core::Duration{0}) << "it never said in the air";
  contact.update(false, false, at(1000));
  contact.update(true, false, at(1100));
  contact.update(true, false, at(1400));
  contact.update(true, false, at(1400));
  EXPECT_EQ(contact.duration(), std::chrono::milliseconds(400));
  contact.update(false, false, at(1500));
  contact.update(true, false, at(1600));
  contact.update(false, false, at(2590));
  EXPECT_EQ(contact.duration(), std::chrono::milliseconds(600)) << "a hop counts";
  contact.update(true, false, at(2595));
  EXPECT_EQ(contact.duration(), std::chrono::milliseconds(1205)) << "as long as the contact before it, at most";
  contact.update(false, false, at(4095));
  EXPECT_EQ(contact.duration(), core::Duration{0});
  contact.update(true, false, at(4200));
  contact.update(false, true, at(4600));
  EXPECT_EQ(contact.duration(), std::chrono::milliseconds(505)) << "a hop counts while it lasts";
}

}  // namespace
}  // namespace m100::safety
