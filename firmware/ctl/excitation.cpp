// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/excitation.h"

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::ctl {
namespace {

// Limits of distance, speed and heading error within which the aircraft is regarded as at rest.
constexpr double kNear_m = 0.3;
constexpr double kStill_m_s = 0.15;
constexpr double kNear_rad = 0.15;
constexpr double kMaxHolding_counts = 200.0;  // a tilt of 10 degrees, more than trim and a moderate wind need

template <typename T>
T absolute(T value) {
  return value < T(0) ? -value : value;
}

}  // namespace

template <typename T>
std::string_view Excitation<T>::name(Abort abort) {
  switch (abort) {
    case Abort::kNone:
      return "none";
    case Abort::kFailsafe:
      return "failsafe";
    case Abort::kFence:
      return "fence";
    case Abort::kDistance:
      return "distance";
    case Abort::kTilt:
      return "tilt";
    case Abort::kSpeed:
      return "speed";
    case Abort::kNotAtRest:
      return "not_at_rest";
  }
  return "none";
}

template <typename T>
void Excitation<T>::start(core::TimePoint now) {
  if (plan_.pieces.empty()) {
    return;
  }
  state_ = State::kReturning;
  abort_ = Abort::kNone;
  piece_ = 0;
  sample_ = 0;
  began_ = ended_ = since_ = restless_ = now;
}

template <typename T>
void Excitation<T>::end(Abort why) {
  state_ = why == Abort::kNone ? State::kOver : State::kAborted;
  abort_ = why;
}

template <typename T>
void Excitation<T>::update_distance(const est::Estimate<T>& estimate, const ref::Window<T>& reference) {
  // Along the axes of the body without its tilt, positive as a positive stick moves it: pitch forward, roll right.
  const core::Vector<T, 2> away_b =
      core::rotate_by_yaw(core::Vector<T, 2>(estimate.x.position_m - reference.x[0].position_m,
                                             estimate.y.position_m - reference.y[0].position_m),
                          -estimate.yaw_rad);
  const core::Vector<T, 2> speed_b =
      core::rotate_by_yaw(core::Vector<T, 2>(estimate.x.velocity_m_s, estimate.y.velocity_m_s), -estimate.yaw_rad);
  switch (axis()) {
    case ExcitedStick::kRoll:
      distance_ = -away_b.y();
      speed_ = -speed_b.y();
      break;
    case ExcitedStick::kPitch:
      distance_ = away_b.x();
      speed_ = speed_b.x();
      break;
    case ExcitedStick::kThrottle:
      distance_ = estimate.height_m - reference.height.position_m;
      speed_ = estimate.climb_m_s;
      break;
    case ExcitedStick::kYaw:
      distance_ = -core::wrap_pi(estimate.yaw_rad - reference.yaw_rad);
      speed_ = -estimate.yaw_rate_rad_s;
      break;
  }
}

template <typename T>
typename Excitation<T>::Abort Excitation<T>::limit_reached(const est::Estimate<T>& estimate, bool brakes) const {
  const ExcitationLimits& limits = plan_.limits[static_cast<std::size_t>(axis())];
  const T outwards = distance_ >= T(0) ? speed_ : -speed_;
  const T way = outwards > T(0) ? outwards * outwards / static_cast<T>(2.0 * limits.braking) : T(0);
  const T tilt = core::sqrt(estimate.x.tilt_rad * estimate.x.tilt_rad + estimate.y.tilt_rad * estimate.y.tilt_rad);
  return brakes                                                        ? Abort::kFence
         : absolute(distance_) + way > static_cast<T>(limits.distance) ? Abort::kDistance
         : tilt > static_cast<T>(limits.tilt_rad)                      ? Abort::kTilt
         : absolute(speed_) > static_cast<T>(limits.speed)             ? Abort::kSpeed
                                                                       : Abort::kNone;
}

template <typename T>
bool Excitation<T>::at_rest(const est::Estimate<T>& estimate, const ref::Window<T>& reference) const {
  const auto near = [](T is, T wanted) { return absolute(is - wanted) < static_cast<T>(kNear_m); };
  const auto still = [](T speed) { return absolute(speed) < static_cast<T>(kStill_m_s); };
  return near(estimate.x.position_m, reference.x[0].position_m) &&
         near(estimate.y.position_m, reference.y[0].position_m) &&
         near(estimate.height_m, reference.height.position_m) && still(estimate.x.velocity_m_s) &&
         still(estimate.y.velocity_m_s) && still(estimate.climb_m_s) &&
         absolute(core::wrap_pi(estimate.yaw_rad - reference.yaw_rad)) < static_cast<T>(kNear_rad);
}

template <typename T>
void Excitation<T>::rest_at(const HoldingSticks<T>& holding) {
  rested_ = restless_ == ended_ ? T(1) : rested_ + T(1);  // not at rest in the last tick: the mean starts again
  holding_.roll_counts += (holding.roll_counts - holding_.roll_counts) / rested_;
  holding_.pitch_counts += (holding.pitch_counts - holding_.pitch_counts) / rested_;
}

template <typename T>
int Excitation<T>::holding_counts() const {
  constexpr T kMax = static_cast<T>(kMaxHolding_counts);
  const T counts = axis() == ExcitedStick::kRoll    ? holding_.roll_counts
                   : axis() == ExcitedStick::kPitch ? holding_.pitch_counts
                                                    : T(0);
  const T within = core::clamp(counts, -kMax, kMax);
  return moves() ? static_cast<int>(within < T(0) ? within - T(0.5) : within + T(0.5)) : 0;
}

template <typename T>
void Excitation<T>::update(const est::Estimate<T>& estimate, const ref::Window<T>& reference, bool may, bool brakes,
                           core::TimePoint now) {
  if (state_ != State::kReturning && state_ != State::kMoving) {
    return;
  }
  ended_ = now;
  update_distance(estimate, reference);
  if (!may) {
    end(Abort::kFailsafe);
    return;
  }
  if (state_ == State::kReturning) {
    restless_ = at_rest(estimate, reference) ? restless_ : now;
    if (now - restless_ >= kRest) {
      state_ = State::kMoving;
      since_ = now;
    } else if (now - since_ > kPatience) {
      end(Abort::kNotAtRest);
    }
    return;
  }
  if (const Abort why = limit_reached(estimate, brakes); why != Abort::kNone) {
    end(why);
    return;
  }
  sample_ = static_cast<std::size_t>((now - since_) / plan_.period);
  if (sample_ >= plan_.pieces[piece_].count) {
    sample_ = 0;
    ++piece_;
    state_ = moves_piece() ? State::kReturning : State::kOver;
    since_ = restless_ = now;
  }
}

template class Excitation<float>;
template class Excitation<double>;

}  // namespace m100::ctl
