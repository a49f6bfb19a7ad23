// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/est/evidence.h"
#include "firmware/est/felt.h"
#include "firmware/est/measurement.h"
#include "firmware/est/motion_check.h"

namespace m100::est {

/// What the pose's own motion is held against, each what the autopilot tells of the same motion (CrossCheck); and the
/// autopilot's own attitude, against its rates (TiltCheck) and against our commands (AnswerCheck).
enum class Check : std::uint8_t {
  kNone,
  kForce,    ///< horizontal velocity that was gained, against the specific force; m/s
  kClimb,    ///< climb speed, against the autopilot's; m/s
  kHeading,  ///< how the heading changed, against the autopilot's; rad
  kMotion,   ///< the path of the last seconds, against that of the specific force; m
  kRates,    ///< how the tilt changed, against the rates of the autopilot; rad
  kAnswer,   ///< the tilt, against what our own commands ask for; rad
};
inline constexpr std::size_t kCheckCount = 7;
std::string_view name(Check check);
std::string_view unit_of(Check check);
/// By its name; nothing: there is no such check.
std::optional<Check> check_of(std::string_view name);

/// A set of checks, one bit each.
using CheckSet = std::uint8_t;
constexpr CheckSet set_of(Check check) {
  return check == Check::kNone ? CheckSet{0} : static_cast<CheckSet>(1U << static_cast<unsigned>(check));
}

/// The check that contradicts the pose, or the attitude.
template <typename T>
struct Contradiction {
  Check check = Check::kNone;  ///< kNone: none does
  T measured{0};               ///< the disagreement, in unit_of(check)
  T allowed{0};
};

/// Holds the motion that the poses tell, as the observer has it, against the motion that the autopilot feels.
///
///   force    g' = v_pose' - (f + o) - g / 2 s   v_pose: the observer's velocity; f: the specific force turned into
///                                               the world; o: what it lacks all the time, found over 20 s
///   climb    c = climb_pose - climb_autopilot
///   heading  h = (yaw_pose - yaw_autopilot) less its mean over 5 s
///   motion   the last seconds of the path: MotionCheck, with evidence of its own
///
/// Each of the others is weighed by what is allowed and summed (Evidence). How the bounds are derived stands beside
/// them in the source.
///
/// The autopilot's horizontal velocity is not used: it reads zero for more than a third of the time and else begins
/// again at zero and drifts by 0.4 m/s in the root of a second, which hides what the specific force shows. Nothing is
/// judged while no pose was used for 0.3 s, and where a part of telemetry does not come; poses that the gate begins to
/// refuse take nothing of the evidence away. An acceleration whose mean over time is neither 1
/// g nor 9.8 m/s^2 has gravity taken away, and is no evidence.
///
/// No heap. Cost: twelve square roots and about 220 products a tick, beside the sines of attitude and heading, which
/// all that look at them share. T is float or double.
template <typename T>
class CrossCheck {
 public:
  /// @param off checks that the operator has switched off.
  explicit CrossCheck(CheckSet off = 0) : off_(off) {}

  /// Once per tick, after the observer.
  /// @param push_w_m_s2 the wind's push in the world as it was while everything agreed (DeadReckoning).
  void update(const Felt<T>& felt, const Estimate<T>& estimate, const core::Vector<T, 2>& push_w_m_s2,
              core::Duration elapsed);

  const Contradiction<T>& report() const { return report_; }
  /// The force, where it comes and is asked, has been held against the poses for two seconds: a body that moves, and
  /// does not feel it, has been seen by then.
  bool has_looked() const { return !force_known_ || (off_ & set_of(Check::kForce)) != 0 || force_seen_s_ >= T(2); }
  /// Force or path disagree by more than is allowed, though not yet for long enough to say so.
  bool doubts() const { return doubts_; }
  /// Horizontal acceleration that is felt, averaged over kFeltMean_s, without the offset: forward and left of the
  /// heading. Nothing: the force does not come, or nobody knows what it is.
  std::optional<core::Vector<T, 2>> felt_h_m_s2() const {
    return force_seen_s_ > T(0) ? std::optional<core::Vector<T, 2>>(felt_h_m_s2_) : std::nullopt;
  }
  /// The largest acceleration lately, without the rotors' shaking.
  T moved_m_s2() const { return moved_m_s2_; }
  /// Not known where the force does not come or the operator has switched its check off.
  const Push<T>& push() const { return push_; }

 private:
  using Vector2 = core::Vector<T, 2>;
  /// Nothing is summed before: the observer's own start ends in this time.
  static constexpr double kBegins_s = 1.0;
  static constexpr core::Duration kPoseUsed = std::chrono::milliseconds(300);

  void feel(const Felt<T>& felt);
  bool is_sane() const;
  void begin_anew();
  void note_push(const core::Turn<T>& yaw, bool is_known, T step_s);
  T gained(const Estimate<T>& estimate, const core::Turn<T>& yaw, T step_s);
  Vector2 lacks_h_m_s2() const;
  T rises_m_s2() const;
  void learn_upwards(T climbed_m_s, T most_m_s, T share, T step_s);
  T turned(const Felt<T>& felt, const Estimate<T>& estimate, T step_s);
  T allowed_m_s(const Vector2& push_w_m_s2) const;
  bool mends(const Estimate<T>& estimate, T step_s);
  void follow(const Felt<T>& felt, const Estimate<T>& estimate, const core::Turn<T>& yaw, T step_s);
  void note_jolt(const Felt<T>& felt, T step_s);
  void note_noise(const Felt<T>& felt, const Estimate<T>& estimate, bool used, T step_s);
  void follow_sideways(const Estimate<T>& estimate, const Vector2& force_w_m_s2, bool sees, T step_s);
  void follow_upwards(const Estimate<T>& estimate, T rises_m_s2, bool sees, T step_s);
  void restart_paths() {
    motion_.restart();
    climbs_.restart();
  }
  T paths_evidence() const;
  void judge(Check check, T disagreement, T allowed, T step_s);

  CheckSet off_;
  bool force_known_ = false;  ///< of the newest one, what it is
  bool knows_velocity_ = false;
  bool knows_heading_ = false;
  bool doubts_ = false;                      ///< more than is allowed: what a lie does may not be learned as an offset
  T force_seen_s_{0};                        ///< how long the offset has been learned; at most its memory
  T force_size_{0};                          ///< mean length of the acceleration, as sent
  Vector2 force_h_m_s2_ = Vector2::Zero();   ///< newest specific force, forward and left, horizontal
  T lifted_m_s2_{0};                         ///< the same upwards, without gravity
  Vector2 tilted_h_m_s2_ = Vector2::Zero();  ///< what the tilt accelerates with, of the same moment
  Vector2 leans_h_m_s2_ = Vector2::Zero();   ///< the mean of it over a second
  Push<T> push_;
  Vector2 offset_h_m_s2_ = Vector2::Zero();   ///< what the force lacks all the time: of the body's x and y
  T offset_up_m_s2_{0};                       ///< and of its z
  Vector2 felt_h_m_s2_ = Vector2::Zero();     ///< the same without its offset and the rotors' shaking
  T moved_m_s2_{0};                           ///< the largest of it in the last second, fading
  Vector2 velocity_w_m_s_ = Vector2::Zero();  ///< of the tick before
  T climb_m_s_{0};                            ///< likewise
  Vector2 gained_w_m_s_ = Vector2::Zero();
  T summed_s_{0};  ///< over how long it is a sum
  T heading_offset_rad_{0};
  std::array<Evidence<T>, kCheckCount> evidence_;
  MotionCheck<T> motion_;
  bool upwards_ = false;  ///< the path that is followed in this tick; the other one is in the next
  Vector2 force_before_w_m_s2_ = Vector2::Zero();  ///< of the tick before
  T rise_before_m_s2_{0};
  MotionCheck<T, 1> climbs_;  ///< the same upwards
  /// White noise, from neighbouring samples: what a lie or a motion changes slowly is none of it.
  struct Noise {
    core::Vector<T, 3> before = core::Vector<T, 3>::Zero();
    T level{0};  ///< mean square of an axis
    T up{0};     ///< of the third
    void add(const core::Vector<T, 3>& now, T weight, T share);
  };
  Noise force_noise_;  ///< density, m^2/s^3
  Noise push_noise_;   ///< of what a pose pushes the observer's place by in a tick, m^2
  core::Vector<T, 3> place_w_m_ = core::Vector<T, 3>::Zero();  ///< of the tick before
  T force_age_s_{0};
  T pushed_s_{0};        ///< since a pose pushed
  T felt_climb_m_s_{0};  ///< as the autopilot told it last
  T felt_gain_m_s_{0};   ///< what the force has made since
  T jolt_m_s_{0};        ///< the most that one told beyond that, since the height was judged
  T mends_for_s_{0};     ///< the poses still mend what the observer predicted without them
  T last_age_s_{0};
  T unused_s_{0};  ///< since a pose was used
  Contradiction<T> report_;
};

extern template class CrossCheck<float>;
extern template class CrossCheck<double>;

}  // namespace m100::est
