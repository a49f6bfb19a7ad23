// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/axis_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <sstream>
#include <string_view>

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::companion::preflight {
namespace {

constexpr double kTick_s = 0.01;
// Less motion than this (root mean square) does not suffice to judge an axis.
constexpr double kMinTilt = 0.05;  ///< of the direction of up: three degrees
constexpr double kMinTurn_rad = 0.03;
constexpr double kMinAcceleration_m_s2 = 0.25;
/// Least correlation by which two axes count as the same.
constexpr double kSure = 0.6;
/// A turn by 45 degrees within a second leaves this mean square of LeverArmFit::turned().
constexpr double kMinTurned = 0.05;
/// A shorter lever arm leaves less than a hand's jerks and the time between pose and force, and flies as none.
constexpr double kNoLever_m = 0.05;
constexpr double kVelocityMean_s = 0.1;  ///< of the poses: 2 mm of noise leave 4 cm/s
constexpr double kNoiseShare = 0.01;     ///< of the least motion; below this share the pose shows noise or nothing

/// Whether the attitude changed by more than 0.1 rad: a lever arm of 0.3 m then moves the pose's origin by 3 cm.
bool is_turned(const core::Quaternion<double>& a, const core::Quaternion<double>& b) {
  constexpr double kCosineOfHalf = 0.99875;
  return std::abs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z) < kCosineOfHalf;
}

double heading(const core::Quaternion<double>& wb) { return core::euler_of(wb).yaw_rad; }

std::string percent(double correlation) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed << "correlation " << correlation;
  return text.str();
}

/// Judges an axis of the pose by `row`, its correlations with the autopilot's axes.
/// @param shown root mean square of the pose's axis. @param motion those of the autopilot's axes. @param min
///   least value of `motion` that suffices.
template <typename Row>
CheckResult judge(std::string_view what, std::string_view how, std::size_t axis, const Row& row, double shown,
                  const Row& motion, double min, std::span<const std::string_view> names) {
  CheckResult check{.name = std::string(what), .health = Health::kDoubtful, .finding = "", .remedy = ""};
  Eigen::Index best = 0;
  row.cwiseAbs().maxCoeff(&best);
  const double correlation = row[best];
  if (motion[static_cast<Eigen::Index>(axis)] < min) {
    check.finding = "not moved enough to tell";
    check.remedy = std::string(how);
    return check;
  }
  if (shown < kNoiseShare * min) {
    check.finding = "the pose does not show this motion: it stays the same while the aircraft moves";
    check.remedy =
        "of the pose's attitude m100 uses the heading alone; a position or a heading that stays the same is an error";
    return check;
  }
  if (std::abs(correlation) < kSure) {
    check.finding = "agrees with no axis of the autopilot (" + percent(correlation) + ")";
    check.health = Health::kBad;
    check.remedy =
        "move one axis at a time, and more slowly; if it stays so, the body of the pose is turned by an angle that is "
        "not a multiple of 90 degrees";
    return check;
  }
  const bool is_own = static_cast<std::size_t>(best) == axis;
  check.health = is_own && correlation > 0.0 ? Health::kGood : Health::kBad;
  if (check.health == Health::kGood) {
    check.finding = "correct (" + percent(correlation) + ")";
    return check;
  }
  const std::string_view sign = correlation < 0.0 ? "minus " : "";
  check.finding = is_own ? "is reversed (" + percent(correlation) + ")"
                         : "is the autopilot's " + std::string(sign) +
                               std::string(names[static_cast<std::size_t>(best)]) + " (" + percent(correlation) + ")";
  check.remedy = "correct the axis at the source of pose; on the wire: world NED, body FRD";
  return check;
}

}  // namespace

void AxisAlignment::add(const Sample& sample) {
  ++samples_;
  force_length_ += sample.force_b.norm();
  window_.push_back(sample);
  if (window_.size() > 2 * kSpan + 1) {
    window_.pop_front();
  }
  add_tilt(sample);
  if (window_.size() > kSpan) {
    add_turn(window_[window_.size() - 1 - kSpan], sample);
  }
  if (window_.size() == 2 * kSpan + 1) {
    add_position();
  }
  add_lever_arm(sample);
}

/// The same comparison as in flight, with the poses in the observer's place.
void AxisAlignment::add_lever_arm(const Sample& sample) {
  est::Estimate<double>& motion = lever_arm_.motion;
  const Eigen::Vector3d before(motion.x.position_m, motion.y.position_m, motion.height_m);
  const Eigen::Vector3d velocity_m_s(motion.x.velocity_m_s, motion.y.velocity_m_s, motion.climb_m_s);
  const Eigen::Vector3d& now = sample.position_w_m;
  const Eigen::Vector3d faster_m_s =
      samples_ == 1 ? Eigen::Vector3d::Zero()
                    : Eigen::Vector3d(((now - before) / kTick_s - velocity_m_s) * (kTick_s / kVelocityMean_s));
  motion.x.position_m = now.x();
  motion.y.position_m = now.y();
  motion.height_m = now.z();
  motion.x.velocity_m_s += faster_m_s.x();
  motion.y.velocity_m_s += faster_m_s.y();
  motion.climb_m_s += faster_m_s.z();
  motion.yaw_rad = heading(sample.pose_wb);
  motion.healthy = true;
  const core::Euler<double> attitude = core::euler_of(sample.autopilot_wb);
  est::ImuSample<double> imu{.attitude_is_new = true, .force_is_new = true};
  imu.roll_rad = attitude.roll_rad;
  imu.pitch_rad = attitude.pitch_rad;
  imu.yaw_rad = attitude.yaw_rad;
  imu.force_b = sample.force_b;
  lever_arm_.consistency.update(imu, motion, core::Vector<double, 2>::Zero(), core::kTickPeriod);
  if (lever_arm_.consistency.lever_arm().turned() > lever_arm_.fit.turned()) {
    lever_arm_.fit = lever_arm_.consistency.lever_arm();
  }
}

CheckResult AxisAlignment::lever_arm_check() const {
  CheckResult check{.name = "lever arm", .health = Health::kDoubtful, .finding = "", .remedy = ""};
  std::ostringstream text;
  text.precision(2);
  text << std::fixed;
  const Eigen::Vector2d lever_b_m = lever_arm_.fit.lever_b_m();
  if (lever_arm_.fit.turned() < kMinTurned) {
    check.finding = "not turned enough to tell";
    check.remedy = "after three seconds at rest turn it left and right about the vertical, by 90 degrees in a second";
  } else if (lever_arm_.fit.longest_m() < kNoLever_m || (!lever_b_m.isZero() && lever_b_m.norm() < kNoLever_m)) {
    text << "the origin of the pose lies within " << kNoLever_m << " m of the centre of gravity, seen from above";
    check.finding = text.str();
    check.health = Health::kGood;
  } else if (lever_b_m.isZero()) {
    text << "cannot tell: pose and force differ by what would need " << lever_arm_.fit.longest_m()
         << " m, and most of it does not turn with the aircraft";
    check.finding = text.str();
    check.remedy = "turn it about the vertical only, on its place, and more evenly";
  } else {
    const Eigen::Array2d shown_b_m = (100.0 * lever_b_m.array()).round() / 100.0 + 0.0;  // no "-0.00"
    text << "the origin of the pose lies " << shown_b_m.x() << " m ahead and " << shown_b_m.y()
         << " m left of the centre of gravity";
    check.finding = text.str();
    text.str("");
    text << "if the flight file does not state it, set offset_m = [" << shown_b_m.x() << ", " << shown_b_m.y()
         << ", Z] in [pose]; measure Z, its height above the centre of gravity";
    check.remedy = text.str();
  }
  return check;
}

void AxisAlignment::add_tilt(const Sample& sample) {
  const Eigen::Vector3d pose = core::up_in_body(sample.pose_wb), autopilot = core::up_in_body(sample.autopilot_wb);
  // Signs as of the angles: nose down is a positive pitch and lowers x; right side down is a positive roll.
  const Eigen::Vector2d p(-pose.x(), pose.y()), a(-autopilot.x(), autopilot.y());
  tilt_products_ += p * a.transpose();
  tilt_pose_ += p;
  tilt_autopilot_ += a;
  tilt_pose_squares_ += p.cwiseAbs2();
  tilt_autopilot_squares_ += a.cwiseAbs2();
  upright_ += pose.z() * autopilot.z();
}

void AxisAlignment::add_turn(const Sample& then, const Sample& now) {
  const double pose = core::wrap_pi(heading(now.pose_wb) - heading(then.pose_wb));
  const double autopilot = core::wrap_pi(heading(now.autopilot_wb) - heading(then.autopilot_wb));
  turn_products_ += pose * autopilot;
  turn_pose_squares_ += pose * pose;
  turn_autopilot_squares_ += autopilot * autopilot;
}

void AxisAlignment::add_position() {
  const core::Quaternion<double>& middle_wb = window_[kSpan].autopilot_wb;
  if (is_turned(window_.front().autopilot_wb, middle_wb) || is_turned(middle_wb, window_.back().autopilot_wb)) {
    return;
  }
  constexpr double kSpan_s = kSpan * kTick_s;
  const Eigen::Vector3d pose =
      (window_.back().position_w_m - 2.0 * window_[kSpan].position_w_m + window_.front().position_w_m) /
      (kSpan_s * kSpan_s);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const double weight = (1.0 - std::abs(static_cast<double>(i) - kSpan) / kSpan) / kSpan;
    const Sample& sample = window_[i];
    const double turn = heading(sample.pose_wb) - heading(sample.autopilot_wb);
    const Eigen::Vector3d there = core::rotation_of(sample.autopilot_wb) * sample.force_b;
    const double c = std::cos(turn), d = std::sin(turn);  // rotation about the vertical into the room's axes
    force += weight * Eigen::Vector3d(c * there.x() - d * there.y(), d * there.x() + c * there.y(), there.z());
  }
  force *= model::kGravity_m_s2 * static_cast<double>(samples_) / std::max(1e-6, force_length_);
  force.z() -= model::kGravity_m_s2;
  position_products_ += pose * force.transpose();
  position_pose_ += pose;
  position_force_ += force;
  position_pose_squares_ += pose.cwiseAbs2();
  position_force_squares_ += force.cwiseAbs2();
  ++positions_;
}

std::vector<CheckResult> AxisAlignment::checks() const {
  constexpr std::array<std::string_view, 2> kTilts{"pitch", "roll"};
  constexpr std::array<std::string_view, 2> kHow{"tilt the nose down and up, by 20 degrees", "tilt it right and left"};
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  constexpr std::array<std::string_view, 3> kPush{"push it 30 cm along x of the room and back, in a second",
                                                  "push it 30 cm along y and back, in a second",
                                                  "lift it 30 cm and lower it, in a second"};
  std::vector<CheckResult> checks;
  const double n = static_cast<double>(std::max<std::size_t>(samples_, 1));
  const Eigen::Vector2d pose_rms =
      ((tilt_pose_squares_ / n) - (tilt_pose_ / n).cwiseAbs2()).cwiseMax(1e-12).cwiseSqrt();
  const Eigen::Vector2d own_rms =
      ((tilt_autopilot_squares_ / n) - (tilt_autopilot_ / n).cwiseAbs2()).cwiseMax(1e-12).cwiseSqrt();
  const Eigen::Matrix2d tilt = tilt_products_ / n - (tilt_pose_ / n) * (tilt_autopilot_ / n).transpose();
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d row = tilt.row(axis).transpose().cwiseQuotient(own_rms * pose_rms[axis]);
    const auto i = static_cast<std::size_t>(axis);
    checks.push_back(judge(kTilts[i], kHow[i], i, row, pose_rms[axis], own_rms, kMinTilt, kTilts));
  }
  if (upright_ < 0.0) {
    checks.push_back({"up", Health::kBad, "the pose is upside down", "on the wire: world NED, body FRD"});
  }
  const Eigen::Matrix<double, 1, 1> turn_rms(std::sqrt(turn_autopilot_squares_ / n));
  const Eigen::Matrix<double, 1, 1> turn(turn_products_ /
                                         std::sqrt(std::max(1e-12, turn_pose_squares_ * turn_autopilot_squares_)));
  constexpr std::array<std::string_view, 1> kHeading{"heading"};
  checks.push_back(judge("heading", "turn it left and right about the vertical, by 45 degrees", 0, turn,
                         std::sqrt(turn_pose_squares_ / n), turn_rms, kMinTurn_rad, kHeading));
  const double m = static_cast<double>(std::max<std::size_t>(positions_, 1));
  const Eigen::Vector3d pose_mean = position_pose_ / m, force_mean = position_force_ / m;  // an offset is not a motion
  const Eigen::Vector3d force_rms = (position_force_squares_ / m - force_mean.cwiseAbs2()).cwiseMax(1e-12).cwiseSqrt();
  const Eigen::Vector3d second_rms = (position_pose_squares_ / m - pose_mean.cwiseAbs2()).cwiseMax(1e-12).cwiseSqrt();
  const Eigen::Matrix3d products = position_products_ / m - pose_mean * force_mean.transpose();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d row = products.row(axis).transpose().cwiseQuotient(force_rms * second_rms[axis]);
    const auto i = static_cast<std::size_t>(axis);
    checks.push_back(judge(std::string("position ") + std::string(kAxes[i]), kPush[i], i, row, second_rms[axis],
                           force_rms, kMinAcceleration_m_s2, kAxes));
  }
  if (std::none_of(checks.begin(), checks.end(), [](const auto& one) { return one.health == Health::kBad; })) {
    checks.push_back(lever_arm_check());
  }
  return checks;
}

}  // namespace m100::companion::preflight
