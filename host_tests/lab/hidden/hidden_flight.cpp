// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/hidden/hidden_flight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host_tests/lab/hidden/random_source.h"
#include "host_tests/lab/hidden/stick_response.h"

namespace m100::lab::hidden {
namespace {

using logs::FlightLog;
using logs::Signal;
using Three = std::array<double, 3>;

constexpr int kStepsPerSample = 5;
constexpr int kStepsPerStick = 10;
constexpr double kG_m_s2 = 9.80665;

/// A pilot's hand: doublets, 3-2-1-1, ramps, chirps and pauses, with a small correction towards the starting point.
class StickInput {
 public:
  double stick(double now_s, double pull, RandomSource& rng) {
    if (now_s >= until_s_) {
      next(now_s, rng);
    }
    const double phase = (now_s - since_s_) / (until_s_ - since_s_);
    double shape = 0.0;
    switch (kind_) {
      case 0:
        shape = phase < 0.5 ? 1.0 : -1.0;
        break;
      case 1:
        shape = (phase < 3.0 / 7 || (phase >= 5.0 / 7 && phase < 6.0 / 7)) ? 1.0 : -1.0;
        break;
      case 2:
        shape = 1.0 - std::abs(2.0 * phase - 1.0);
        break;
      case 3:
        shape = std::sin(2.0 * std::numbers::pi * phase * (1.0 + 2.0 * phase));
        break;
      default:
        break;
    }
    return std::clamp(std::round(amplitude_ * shape + pull), -kTravel_counts, kTravel_counts);
  }

 private:
  void next(double now_s, RandomSource& rng) {
    kind_ = static_cast<int>(rng.between(0.0, 4.99));
    since_s_ = now_s;
    until_s_ = now_s + rng.between(0.8, 2.6);
    const double size = rng.between(60.0, 320.0);
    amplitude_ = rng.between(0.0, 1.0) < 0.5 ? -size : size;
  }

  int kind_ = 4;
  double since_s_ = 0.0;
  double until_s_ = 1.0;
  double amplitude_ = 0.0;
};

class Flight {
 public:
  explicit Flight(const FlightPlan& plan)
      : plan_(plan),
        on_axis_(plan.axis == "roll" ? plan.hidden : nothing_),
        rng_(plan.seed),
        roll_{.scale_rad = rng_.between(8e-4, 1.05e-3),
              .frequency_rad_s = rng_.between(7.0, 11.0),
              .damping = rng_.between(0.6, 0.85)},
        pitch_{.scale_rad = rng_.between(8e-4, 1.05e-3),
               .frequency_rad_s = rng_.between(7.0, 11.0),
               .damping = rng_.between(0.6, 0.85)},
        roll_path_(on_axis_, delay_of(plan)),
        pitch_path_(nothing_, rng_.between(0.02, 0.05)),
        line_hz_(rng_.between(0.25, 0.9)),
        line_phase_(rng_.between(0.0, 6.28)),
        direction_(rng_.between(0.0, 6.28)) {}

  FlightLog run() {
    prepare();
    const auto samples = static_cast<std::size_t>(std::lround(plan_.length_s * 100.0));
    for (std::size_t k = 0; k < samples; ++k) {
      record(k);
      for (int i = 0; i < kStepsPerSample; ++i) {
        step();
      }
    }
    shift_attitude();
    return std::move(log_);
  }

 private:
  static double delay_of(const FlightPlan& plan) {
    const double hidden_s = plan.axis == "roll" ? value_of(plan.hidden, "transport_delay") : 0.0;
    const double with_zero_s = plan.axis == "roll" && plan.hidden.count("lead_zero") > 0 ? 0.06 : 0.03;
    return hidden_s > 0.0 ? hidden_s : with_zero_s;
  }

  double on_translation(const char* name) const {
    return plan_.axis == "translation" ? value_of(plan_.hidden, name) : 0.0;
  }

  void prepare() {
    log_.file = "hidden flight " + std::to_string(plan_.seed);
    log_.size = static_cast<std::size_t>(std::lround(plan_.length_s * 100.0));
    log_.gap.assign(log_.size, 0);
    std::vector<Signal> logged{Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kAttitudeYaw,
                               Signal::kPositionX,    Signal::kPositionY,     Signal::kPositionZ,
                               Signal::kVelocityX,    Signal::kVelocityY,     Signal::kVelocityZ};
    const std::vector<Signal> more =
        plan_.logs_thrust
            ? std::vector<Signal>{Signal::kThrustRatio, Signal::kThrustDirX, Signal::kThrustDirY, Signal::kThrustDirZ}
            : std::vector<Signal>{Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw,
                                  Signal::kRateX,     Signal::kRateY,      Signal::kRateZ,         Signal::kForceX,
                                  Signal::kForceY,    Signal::kForceZ};
    logged.insert(logged.end(), more.begin(), more.end());
    for (const Signal signal : logged) {
      log_.of(signal).assign(log_.size, 0.0);
    }
    if (plan_.hidden.count("dropout") > 0) {
      for (double at = rng_.between(4.0, 6.0); at < plan_.length_s; at += rng_.between(2.5, 6.0)) {
        dropouts_.emplace_back(at, at + plan_.hidden.at("dropout"));
      }
    }
  }

  void step() {
    if (count_ % kStepsPerStick == 0) {
      const double c = std::cos(yaw_rad_);
      const double s = std::sin(yaw_rad_);
      const double forward = c * pull(0) + s * pull(1);
      const double left = -s * pull(0) + c * pull(1);
      sticks_[0] = roll_hand_.stick(now_s_, left, rng_);
      sticks_[1] = pitch_hand_.stick(now_s_, -forward, rng_);
      sticks_[2] = 0.5 * climb_hand_.stick(now_s_, 120.0 * position_[2], rng_);
      sticks_[2] = std::clamp(sticks_[2] - 240.0 * position_[2], -kTravel_counts, kTravel_counts);
      sticks_[3] = plan_.constant_heading ? 0.0 : 0.6 * yaw_hand_.stick(now_s_, 0.0, rng_);
    }
    turn();
    move();
    now_s_ += kStep_s;
    ++count_;
  }

  double pull(std::size_t axis) const { return 14.0 * position_[axis] + 25.0 * velocity_[axis]; }

  void turn() {
    double sent = sticks_[0];
    for (const auto& [from_s, to_s] : dropouts_) {
      sent = now_s_ >= from_s && now_s_ < to_s ? 0.0 : sent;
    }
    const double roll_target = roll_.scale_rad * roll_path_.pass(sent, sticks_[1], now_s_);
    const double pitch_target = pitch_.scale_rad * pitch_path_.pass(sticks_[1], sticks_[0], now_s_);
    double limit = value_of(on_axis_, "saturation");
    if (const double both = value_of(on_axis_, "tilt_limit"); both > 0.0) {
      const double size = std::hypot(roll_target, pitch_target);
      const double cut = size > both ? both / size : 1.0;
      roll_.step(cut * roll_target, value_of(on_axis_, "lead_zero"), 0.0, 0.0);
      pitch_.step(cut * pitch_target, 0.0, 0.0, 0.0);
    } else {
      roll_.step(roll_target, value_of(on_axis_, "lead_zero"), value_of(on_axis_, "rate_limit"), limit);
      pitch_.step(pitch_target, 0.0, 0.0, 0.0);
    }
    yaw_rate_rad_s_ += kStep_s / 0.2 * (-2.2e-3 * sticks_[3] - yaw_rate_rad_s_);
    yaw_rad_ += kStep_s * yaw_rate_rad_s_;
    climb_m_s_ += kStep_s / 0.35 * (2.6e-3 * sticks_[2] - climb_m_s_);
    for (GaussMarkovNoise& air : attitude_air_) {
      air.step(rng_);
    }
    const double line = value_of(on_axis_, "sine") * std::sin(2 * std::numbers::pi * line_hz_ * now_s_ + line_phase_);
    roll_rad_ = roll_.angle + attitude_air_[0].value() + line;
    pitch_rad_ = pitch_.angle + attitude_air_[1].value();
  }

  /// Body z axis in the world for z-y-x angles.
  static Three body_z(double roll, double pitch, double yaw) {
    return {std::cos(yaw) * std::sin(pitch) * std::cos(roll) + std::sin(yaw) * std::sin(roll),
            std::sin(yaw) * std::sin(pitch) * std::cos(roll) - std::cos(yaw) * std::sin(roll),
            std::cos(pitch) * std::cos(roll)};
  }

  void move() {
    const double heading_error = on_translation("yaw_misalignment");
    b3_ = body_z(roll_rad_, pitch_rad_, yaw_rad_ + heading_error);
    // The height loop commands the acceleration that keeps the climb speed; the rotor follows with a lag and a gain.
    const double wanted = kG_m_s2 + 4.0 * (climb_m_s_ - velocity_[2]) + thrust_trim_;
    thrust_trim_ += kStep_s * 3.0 * (climb_m_s_ - velocity_[2]);
    set_point_ = std::clamp(wanted / std::max(0.5, b3_[2]), 0.4 * kG_m_s2, 1.7 * kG_m_s2);
    const double lag_s = std::max(on_translation("thrust_lag"), 1e-9);
    thrust_ += (1.0 - std::exp(-kStep_s / lag_s)) * (set_point_ - thrust_);
    const double gain = on_translation("thrust_gain");
    const double thrust = thrust_ * (gain > 0.0 ? gain : 1.0);
    const double tilt_gain = on_translation("tilt_gain") > 0.0 ? on_translation("tilt_gain") : 1.0;
    force_ = outside_forces();
    acceleration_ = {tilt_gain * thrust * b3_[0] + force_[0], tilt_gain * thrust * b3_[1] + force_[1],
                     thrust * b3_[2] - kG_m_s2 + force_[2]};
    for (std::size_t c = 0; c < 3; ++c) {
      velocity_[c] += kStep_s * acceleration_[c];
      position_[c] += kStep_s * velocity_[c];
    }
  }

  Three outside_forces() {
    Three f{};
    for (std::size_t c = 0; c < 3; ++c) {
      f[c] = air_[c].step(rng_);
    }
    const double wind = on_translation("steady_wind");
    f[0] += wind * std::cos(direction_);
    f[1] += wind * std::sin(direction_);
    const double bias = on_translation("body_bias");
    f[0] += bias * std::cos(direction_ + yaw_rad_);
    f[1] += bias * std::sin(direction_ + yaw_rad_);
    const double speed = std::hypot(velocity_[0], velocity_[1], velocity_[2]);
    const double drag = on_translation("linear_drag") + on_translation("quadratic_drag") * speed;
    double along = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      f[c] -= drag * velocity_[c];
      along += b3_[c] * velocity_[c];
    }
    for (std::size_t c = 0; c < 3; ++c) {
      f[c] -= on_translation("axial_inflow") * along * b3_[c];
    }
    // body_drag: three tenths of it along the nose, all of it across.
    const double slip = std::cos(yaw_rad_) * velocity_[1] - std::sin(yaw_rad_) * velocity_[0];
    const double body = on_translation("body_drag");
    f[0] -= body * (0.3 * velocity_[0] - 0.7 * slip * std::sin(yaw_rad_));
    f[1] -= body * (0.3 * velocity_[1] + 0.7 * slip * std::cos(yaw_rad_));
    const double line = std::sin(2 * std::numbers::pi * line_hz_ * now_s_ + line_phase_);
    f[0] += on_translation("periodic_wind") * line * std::cos(direction_);
    f[1] += on_translation("periodic_wind") * line * std::sin(direction_);
    swing(f);
    // Outside of any library: a force proportional to a product of b3 and velocity.
    f[0] += on_translation("product") * b3_[1] * velocity_[0];
    f[1] += on_translation("product") * b3_[0] * velocity_[1];
    return f;
  }

  /// A load on a rope of 1.2 m, with its mass as a share of the vehicle's: small-angle pendulum driven by the vehicle.
  void swing(Three& f) {
    const double share = on_translation("slung_load");
    if (share <= 0.0) {
      return;
    }
    constexpr double kRope_m = 1.2;
    for (std::size_t c = 0; c < 2; ++c) {
      const double pull = kG_m_s2 * rope_[c];
      rope_rate_[c] += kStep_s * (-(1.0 + share) * pull - thrust_ * b3_[c] - 0.12 * kRope_m * rope_rate_[c]) / kRope_m;
      rope_[c] += kStep_s * rope_rate_[c];
      f[c] += share * pull;
    }
  }

  void record(std::size_t k) {
    const auto put = [&](Signal signal, double value, double sigma) {
      if (auto& series = log_.of(signal); !series.empty()) {
        series[k] = value + rng_.normal(sigma);
      }
    };
    for (int i = 0; i < 4; ++i) {
      put(logs::offset(Signal::kStickRoll, i), sticks_[static_cast<std::size_t>(i)], 0.0);
    }
    put(Signal::kAttitudeRoll, roll_rad_, 0.002);
    put(Signal::kAttitudePitch, pitch_rad_, 0.002);
    put(Signal::kAttitudeYaw, yaw_rad_, 0.002);
    put(Signal::kRateX, roll_.rate, 0.01);
    put(Signal::kRateY, pitch_.rate, 0.01);
    put(Signal::kRateZ, yaw_rate_rad_s_, 0.01);
    const Three direction = body_z(roll_rad_, pitch_rad_, yaw_rad_);
    const Three specific_force{acceleration_[0], acceleration_[1], acceleration_[2] + kG_m_s2};
    const double c = std::cos(yaw_rad_);
    const double s = std::sin(yaw_rad_);
    const double ahead = c * specific_force[0] + s * specific_force[1];
    const double aside = -s * specific_force[0] + c * specific_force[1];
    const double along = std::sin(pitch_rad_) * ahead + std::cos(pitch_rad_) * specific_force[2];
    put(Signal::kForceX, std::cos(pitch_rad_) * ahead - std::sin(pitch_rad_) * specific_force[2], 0.08);
    put(Signal::kForceY, std::cos(roll_rad_) * aside + std::sin(roll_rad_) * along, 0.08);
    put(Signal::kForceZ, -std::sin(roll_rad_) * aside + std::cos(roll_rad_) * along, 0.1);
    put(Signal::kThrustRatio, set_point_ / kG_m_s2, 0.0);
    for (int i = 0; i < 3; ++i) {
      const auto n = static_cast<std::size_t>(i);
      put(logs::offset(Signal::kPositionX, i), position_[n], 0.001);
      put(logs::offset(Signal::kVelocityX, i), velocity_[n], 0.012);
      put(logs::offset(Signal::kThrustDirX, i), direction[n], 0.002);
    }
  }

  /// Applies time_offset: the time stamps of attitude and thrust are too late (offset < 0) or too early (> 0).
  void shift_attitude() {
    const int samples = static_cast<int>(std::lround(100.0 * on_translation("time_offset")));
    if (samples == 0) {
      return;
    }
    for (const Signal first : {Signal::kAttitudeRoll, Signal::kThrustDirX}) {
      for (int i = 0; i < 3; ++i) {
        move_earlier(log_.of(logs::offset(first, i)), samples);
      }
    }
    move_earlier(log_.of(Signal::kThrustRatio), samples);
  }

  static void move_earlier(std::vector<double>& values, int samples) {
    const std::vector<double> old = values;
    const int last = static_cast<int>(old.size()) - 1;
    for (int k = 0; k <= last; ++k) {
      values[static_cast<std::size_t>(k)] = old[static_cast<std::size_t>(std::clamp(k + samples, 0, last))];
    }
  }

  const FlightPlan& plan_;
  const HiddenEffects nothing_{};
  const HiddenEffects& on_axis_;
  RandomSource rng_;
  Tilt roll_, pitch_;
  StickPath roll_path_, pitch_path_;
  double line_hz_, line_phase_, direction_;
  FlightLog log_;
  StickInput roll_hand_, pitch_hand_, climb_hand_, yaw_hand_;
  std::array<GaussMarkovNoise, 2> attitude_air_{GaussMarkovNoise(0.004, 0.5), GaussMarkovNoise(0.004, 0.5)};
  std::array<GaussMarkovNoise, 3> air_{GaussMarkovNoise(0.05, 0.35), GaussMarkovNoise(0.05, 0.35),
                                       GaussMarkovNoise(0.05, 0.35)};
  std::vector<std::pair<double, double>> dropouts_;
  std::array<double, 4> sticks_{};
  double roll_rad_ = 0, pitch_rad_ = 0, yaw_rad_ = 0.2, yaw_rate_rad_s_ = 0, climb_m_s_ = 0;
  Three position_{}, velocity_{}, acceleration_{}, force_{}, b3_{0, 0, 1};
  double set_point_ = kG_m_s2, thrust_ = kG_m_s2, thrust_trim_ = 0.0;
  std::array<double, 2> rope_{}, rope_rate_{};
  double now_s_ = 0;
  long count_ = 0;
};

}  // namespace

FlightLog fly(const FlightPlan& plan) { return Flight(plan).run(); }

}  // namespace m100::lab::hidden
