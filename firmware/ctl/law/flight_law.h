// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/core/tick_count.h"
#include "firmware/core/tilt.h"
#include "firmware/core/time.h"
#include "firmware/ctl/command.h"
#include "firmware/ctl/law/altitude_pid.h"
#include "firmware/ctl/law/fallback_law.h"
#include "firmware/ctl/law/paper_state.h"
#include "firmware/ctl/law/setpoint_planner.h"
#include "firmware/ctl/law/yaw_p.h"
#include "firmware/est/estimate.h"
#include "firmware/model/vehicle.h"
#include "firmware/mpc/delay_predictor.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

struct FlightLawOptions {
  /// Limit of the commanded tilt of both axes together, above 0 and below 90 degrees. The flown tilt may exceed it
  /// briefly (slope_limit.h), but must stay below 35 degrees (promise R12).
  double combined_tilt_limit_rad = 0.5235987755982988;  // 30 deg
  /// Law of the horizontal axes; the baseline (kLqr) differs from the MPC only in the optimisation.
  mpc::Law horizontal = mpc::Law::kMpc;
  bool paper_state = false;  ///< the horizontal state is PaperState's instead of the observer's
};

/// How the horizontal commands were computed when they were last solved, for the log.
struct LawReport {
  mpc::Path path_x = mpc::Path::kTable;
  mpc::Path path_y = mpc::Path::kTable;
  unsigned changes = 0;       ///< of the active sets, both axes together
  bool tilt_limited = false;  ///< the combined limit reduced the tilt
  bool fallback = false;      ///< the fallback law flies; paths and changes are still those of the tables' law
};

/// The control law: MPC (or its baseline) in x and y, PID in height, P in yaw.
///
/// Horizontal, per axis of the yaw-free world frame (paper, III-E.1):
///  1. The command in force enters the delay line of the DelayPredictor; the state is predicted to now + delay.
///  2. Targets. Tilts are taken as tangents, t = tan(tilt), which makes v' = +-g t - c v + d linear at any tilt:
///       t_ref = +-(a_ref + c v_ref - d) / g,   input target s = t_ref + T1 t_ref' + T2 t_ref''
///     (inverse_lags(): the input that makes the attitude loop follow t_ref).
///  3. The program is solved for the input as the attitude loop sees it, u + m; the command is that minus m. So neither
///     wind (d) nor trim and command gain (m) leaves a steady offset.
/// Then both tilts are limited together, keeping their direction, with regard to the present tilt (slope_limit.h), and
/// rotated by yaw into roll and pitch.
/// The reference's window must begin lead() after now. Cost: firmware/RESULTS.md.
template <typename T>
class FlightLaw {
 public:
  /// The tables must outlive the law.
  FlightLaw(const model::Vehicle& vehicle, const mpc::GainTables<T>& tables, const FlightLawOptions& options = {});

  /// Once per tick. @param applied_command the command sent to the autopilot since the last tick, after supervisor and
  /// stick rounding; it enters the prediction through the delay.
  /// @param solves false: the last solved tilts are kept, because no command can leave in this tick. The delay lines,
  ///   height and yaw are updated; the window's points in x and y are not read.
  Command<T> update(const est::Estimate<T>& estimate, const ref::Window<T>& reference,
                    const Command<T>& applied_command, core::Duration elapsed, bool solves = true);

  /// How far ahead of now the window must begin: the transport delay of pitch (that of roll is accounted for).
  core::Duration lead() const { return x_.predictor.lead(); }
  const LawReport& report() const { return report_; }
  /// Largest slope that is available to one axis whatever the other one wants: the smaller of the tables' boxes and the
  /// combined limit divided by the root of two.
  T slope_limit() const;
  /// Replaces the jump to a set point by the fastest motion (setpoint_planner.h), unless the fallback law flies.
  void plan(ref::Window<T>& window, const est::Estimate<T>& estimate, const GeofenceLimiter<T>& fence,
            core::TimePoint now, std::size_t points) {
    fallback() ? planner_.reset() : planner_.update(window, estimate, fence, now, lead(), points);
  }
  /// From now on, until reset(), the fallback law (fallback_law.h) flies both horizontal axes with this bandwidth.
  void start_fallback(T rate_per_s) { fallback_per_s_ = rate_per_s; }
  bool fallback() const { return fallback_per_s_ > T(0); }
  /// For a start in the air: clears the integral, the active sets, the fallback law and the planned motion. The delay
  /// lines keep the commands that were sent.
  void reset();

 private:
  using References = std::array<ref::AxisReference<T>, ref::kHorizon + 1>;
  struct Axis {
    mpc::HorizontalMpc<T> mpc;
    mpc::DelayPredictor<T> predictor;
    FallbackLaw<T> fallback{};
    T first_lag_s{0};    ///< T1
    T second_lag_s2{0};  ///< T2
    T acts_s{0};         ///< effective_delay_s()
    T soon{0};           ///< slope predicted for acts_s from now
    mpc::Path path = mpc::Path::kTable;
    unsigned changes = 0;
  };
  static Axis make_axis(const mpc::GainTable<T>& table, const model::StickAxis& axis, mpc::Law law);
  T solve(Axis& axis, const est::AxisEstimate<T>& estimate, const References& reference, bool constant, T lead_gap_s,
          T applied_slope);
  /// Slopes (tangents of tilt) of both axes from the MPC or its baseline or, once it was started, from the fallback
  /// law; both together are kept within the combined limit.
  core::Slope<T> slopes(const est::Estimate<T>& estimate, const ref::Window<T>& reference,
                        const core::Slope<T>& applied_command, T step_s);

  Axis x_;
  Axis y_;
  AltitudePid<T> height_;
  YawP<T> yaw_;
  core::CachedTilt<T> commanded_slope_;
  core::TickCount time_;  ///< of the delay lines
  T climb_lag_s_{0};
  T fallback_per_s_{0};  ///< 0: the tables' law flies
  T combined_tangent_{0};
  SetpointPlanner<T> planner_;
  core::Euler<T> attitude_{};  ///< roll and pitch as they were solved last
  mpc::Problem<T> problem_;
  mpc::Solution<T> solution_;
  LawReport report_;
  bool takes_paper_state_;
  PaperState<T> paper_state_;
};

}  // namespace m100::ctl
