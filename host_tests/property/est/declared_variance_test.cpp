// SPDX-License-Identifier: BSD-3-Clause
// A source of pose may declare any variance. For noise of that size the observer's error stays within five of its own
// sigmas; it neither grows nor oscillates, whatever the rate, age and gaps of the poses. Only the public interface of
// DisturbanceEkf is used.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <ostream>
#include <random>

#include "firmware/core/tilt.h"
#include "host_tests/unit/est/observed_vehicle.h"
#include "host_tests/unit/est/scalars.h"

namespace m100::est {
namespace {

constexpr double kTickLength_s = 0.01;

/// What a drawn flight varies.
struct Flight {
  double sigma_m = 0.1;    ///< declared by the source; its noise has this size, too
  double rate_hz = 50.0;   ///< of the poses
  double age_s = 0.02;     ///< from capture to use
  double gap_s = 0.0;      ///< every four seconds no pose comes for this long
  double wind_m_s2 = 0.0;  ///< acceleration by wind, constant
  double swing_rad = 0.0;  ///< amplitude of the commanded tilt; 0: at rest, before control
  unsigned seed = 1;
};

std::ostream& operator<<(std::ostream& out, const Flight& f) {
  return out << "sigma " << f.sigma_m << " m, " << f.rate_hz << " Hz, age " << f.age_s << " s, gap " << f.gap_s
             << " s, wind " << f.wind_m_s2 << " m/s^2, swing " << f.swing_rad << " rad, seed " << f.seed;
}

struct Bounds {
  double max_sigma_m, min_rate_hz, max_age_s, max_gap_s;
};

/// Evenly over the whole range from the first case on.
int drawn_whole(int low, int high) { return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(low, high)); }

Flight drawn_flight(const Bounds& bounds) {
  const auto between = [](double low, double high) { return low + (high - low) * drawn_whole(0, 10001) * 1e-4; };
  Flight f;
  f.sigma_m = std::pow(10.0, between(-4.0, std::log10(bounds.max_sigma_m)));
  f.rate_hz = std::pow(10.0, between(std::log10(bounds.min_rate_hz), std::log10(250.0)));
  f.age_s = between(0.0, bounds.max_age_s);
  f.gap_s = drawn_whole(0, 2) * between(0.1, bounds.max_gap_s);
  if (drawn_whole(0, 2) == 1) {
    f.wind_m_s2 = between(-1.0, 1.0);
    f.swing_rad = between(0.01, 0.15);
  }
  f.seed = static_cast<unsigned>(drawn_whole(0, 1 << 30));
  return f;
}

/// The true motion of one axis: the tilt follows the delayed command, and the aircraft accelerates with tilt and wind.
struct TrueAxis {
  double wind_m_s2, sign, tilt_rad, rate_rad_s = 0.0, velocity_m_s = 0.0, position_m = 0.0;

  TrueAxis(double wind, double of) : wind_m_s2(wind), sign(of), tilt_rad(trim_rad()) {}
  double trim_rad() const { return -sign * std::atan(wind_m_s2 / model::kGravity_m_s2); }
  void move(const model::StickAxis& axis, double command_rad, double step_s) {
    const double w = axis.natural_frequency_rad_s;
    rate_rad_s += step_s * (w * w * (command_rad - tilt_rad) - 2.0 * axis.damping_ratio * w * rate_rad_s);
    tilt_rad += step_s * rate_rad_s;
    velocity_m_s += step_s * (sign * model::kGravity_m_s2 * std::tan(tilt_rad) + wind_m_s2);
    position_m += step_s * velocity_m_s;
  }
};

/// How far the observer was off.
struct Worst {
  double sigmas = 0.0;    ///< largest error of x and y over their own sigmas
  double error_m = 0.0;   ///< the same in metres, once wind and trim are known
  double height_m = 0.0;  ///< likewise of the height
  int valid_ticks = 0;
};

template <typename Scalar>
class ObservedFlight {
 public:
  using Real = typename Scalar::Real;

  explicit ObservedFlight(const Flight& flight)
      : flight_(flight), random_(flight.seed), x_(flight.wind_m_s2, 1.0), y_(-flight.wind_m_s2, -1.0) {}

  Worst fly(double duration_s) {
    for (int tick = 1; tick * kTickLength_s < duration_s; ++tick) {
      move(tick * kTickLength_s);
      const Estimate<Real>& e = filter_.update(measurement(), command(), core::kTickPeriod);
      if (e.prediction_valid) {
        judge(e);
      }
    }
    return worst_;
  }
  const typename Scalar::Filter& filter() const { return filter_; }

 private:
  static constexpr double kPosesCome_s = 4.0;
  static constexpr double kLearned_s = 5.0;  ///< then wind and trim are known
  static constexpr int kSteps = 10;          // of the true motion in a tick
  double noise(double sigma) { return sigma * normal_(random_); }
  double wanted_rad(const TrueAxis& axis, double t_s) const {
    return axis.trim_rad() + flight_.swing_rad * std::cos(2.0 * t_s);
  }
  /// The command that was sent last: the tick's motion had it.
  ctl::Command<Real> command() const {
    const core::Euler<double> sent = core::attitude_of<double>({wanted_rad(x_, t_s_), wanted_rad(y_, t_s_)}, 0.0);
    return {.roll_rad = static_cast<Real>(sent.roll_rad), .pitch_rad = static_cast<Real>(sent.pitch_rad)};
  }
  void move(double t_s) {
    const core::Euler<double> before = attitude();
    t_s_ = t_s;
    for (int step = 0; step < kSteps; ++step) {
      const double acts_s = t_s - kTickLength_s - vehicle_.pitch.transport_delay_s;
      const double held_s = kTickLength_s * std::ceil((acts_s + step * kTickLength_s / kSteps) / kTickLength_s);
      x_.move(vehicle_.pitch, wanted_rad(x_, held_s), kTickLength_s / kSteps);
      y_.move(vehicle_.roll, wanted_rad(y_, held_s), kTickLength_s / kSteps);
    }
    rate_ = {(attitude().roll_rad - before.roll_rad) / kTickLength_s,
             (attitude().pitch_rad - before.pitch_rad) / kTickLength_s};
    captured_.push_front({x_.position_m, y_.position_m});
    captured_.resize(std::min<std::size_t>(captured_.size(), 32));
    due_poses_ += kTickLength_s * flight_.rate_hz;
  }
  core::Euler<double> attitude() const { return core::attitude_of<double>({x_.tilt_rad, y_.tilt_rad}, 0.0); }

  Measurement<Real> measurement() {
    Measurement<Real> m;
    const core::Euler<double> tilted = attitude();
    m.now = core::TimePoint(core::Duration(std::llround(t_s_ * 1e6)));
    m.attitude.is_new = true;
    m.attitude.roll_rad = static_cast<Real>(tilted.roll_rad + noise(0.003));
    m.attitude.pitch_rad = static_cast<Real>(tilted.pitch_rad + noise(0.003));
    m.attitude.rate_b_rad_s = {static_cast<Real>(rate_.x() + noise(0.01)), static_cast<Real>(rate_.y() + noise(0.01)),
                               Real(0)};
    const auto ticks = static_cast<std::size_t>(std::lround(flight_.age_s / kTickLength_s));
    const bool gap = std::fmod(t_s_, kPosesCome_s + flight_.gap_s) > kPosesCome_s;
    if (due_poses_ < 1.0 || gap || captured_.size() <= ticks) {
      return m;
    }
    due_poses_ -= std::floor(due_poses_);
    m.pose.is_new = true;
    m.pose.set_captured_at(m.now - static_cast<int>(ticks) * core::kTickPeriod);
    m.pose.position_w_m = {static_cast<Real>(captured_[ticks].x() + noise(flight_.sigma_m)),
                           static_cast<Real>(captured_[ticks].y() + noise(flight_.sigma_m)),
                           static_cast<Real>(1.0 + noise(flight_.sigma_m))};
    m.pose.yaw_rad = static_cast<Real>(noise(0.002));
    m.pose.position_variance_m2.setConstant(static_cast<Real>(flight_.sigma_m * flight_.sigma_m));
    return m;
  }

  void judge(const Estimate<Real>& e) {
    ++worst_.valid_ticks;
    const auto axis = [this](const AxisEstimate<Real>& seen, const TrueAxis& real) {
      const double error_m = std::abs(static_cast<double>(seen.position_m) - real.position_m);
      worst_.sigmas = std::max(worst_.sigmas, error_m / std::sqrt(static_cast<double>(seen.position_variance_m2)));
      worst_.error_m = t_s_ > kLearned_s ? std::max(worst_.error_m, error_m) : worst_.error_m;
    };
    axis(e.x, x_);
    axis(e.y, y_);
    worst_.height_m =
        t_s_ > kLearned_s ? std::max(worst_.height_m, std::abs(static_cast<double>(e.height_m) - 1.0)) : 0.0;
  }

  Flight flight_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  model::Vehicle vehicle_ = vehicle();
  typename Scalar::Filter filter_{vehicle_};
  TrueAxis x_, y_;
  core::Vector<double, 2> rate_ = core::Vector<double, 2>::Zero();
  std::deque<core::Vector<double, 2>> captured_;
  double t_s_ = 0.0, due_poses_ = 0.0;
  Worst worst_;
};

constexpr Bounds kBounds{.max_sigma_m = 1000.0, .min_rate_hz = 5.0, .max_age_s = 0.2, .max_gap_s = 1.5};

template <typename Ekf>
class DeclaredVariance : public ::testing::Test {};
TYPED_TEST_SUITE(DeclaredVariance, Scalars);

// Catches a covariance whose range ends inside the declared variances: a sigma that is held at its end leaves the
// gains of an unstable filter, and the estimate swings up to 100 m and 25 m/s. Catches a start that trusts the first
// poses more than their sender does, and a gate that uses only the poses near the prediction.
TYPED_TEST(DeclaredVariance, ErrorsStayWithinFiveOfTheirOwnSigmas) {
  setenv("RC_PARAMS", "seed=52 max_success=200", 0);
  EXPECT_TRUE(rc::check("noise of the declared size", [] {
    const Flight flight = drawn_flight(kBounds);
    RC_LOG() << flight;
    const Worst worst = ObservedFlight<TypeParam>(flight).fly(20.0);
    RC_ASSERT(worst.valid_ticks > 1500);
    RC_ASSERT(worst.sigmas <= 5.0);
    // The height has no sigma of its own in the estimate. Two poses 0.1 s apart that start it, predicted over the age,
    // err by up to 1 + 2 age / 0.1 s of their sigmas; between two poses its climb may be wrong by 0.5 m/s in 0.1 s.
    RC_ASSERT(worst.height_m <= 5.0 * flight.sigma_m * (1.0 + 20.0 * flight.age_s) + 0.05);
  }));
}

TYPED_TEST(DeclaredVariance, BelowAMillimetreErrorsStayBelowFive) {
  setenv("RC_PARAMS", "seed=52 max_success=200", 0);
  EXPECT_TRUE(rc::check("a source of less than 1 mm", [] {
    Bounds bounds = kBounds;
    bounds.max_sigma_m = 1e-3;
    // Over a longer prediction, age and interval, the noise of 1 mm alone becomes more.
    bounds.max_age_s = 0.05;
    bounds.min_rate_hz = std::max(bounds.min_rate_hz, 12.0);
    Flight flight = drawn_flight(bounds);
    flight.gap_s = 0.0;
    RC_LOG() << flight;
    const Worst worst = ObservedFlight<TypeParam>(flight).fly(20.0);
    RC_ASSERT(worst.valid_ticks > 1500);
    RC_ASSERT(worst.error_m <= 5e-3);
  }));
}

}  // namespace
}  // namespace m100::est
