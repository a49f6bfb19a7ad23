// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/app/source_frame.h"
#include "firmware/core/status.h"
#include "firmware/ctl/law/flight_law.h"
#include "firmware/est/measurement.h"
#include "firmware/link/pose/pose_link.h"
#include "firmware/link/serial_link.h"
#include "firmware/log/records.h"
#include "firmware/safety/supervisor.h"
#include "firmware/vrc/sticks.h"

namespace m100::app {

/// One tick in one copy, made of the values of the parts. The flight log, the live display and the ground station read
/// it. World NWU, body FLU. T is float or double.
template <typename T>
struct TickRecord {
  core::TimePoint now{};
  core::Duration elapsed{0};     ///< since the tick before
  std::uint32_t orders = 0;      ///< of the operator, given before this tick: log::kOrder*
  est::Measurement<T> measured;  ///< the newest pose and attitude; is_new: it came in this tick
  est::Estimate<T> estimate;
  core::Vector<T, 3> course_w_m = core::Vector<T, 3>::Zero();  ///< where the course is now
  /// x, y, z, as the law follows it: planned, inside the fence; x and y lead by FlightLaw::lead().
  std::array<ref::AxisReference<T>, 3> reference{};
  T reference_yaw_rad{0};
  ctl::Command<T> wanted{};  ///< of law and excitation
  safety::SupervisedCommand<T> supervised;
  vrc::Sticks sticks;  ///< as last sent
  core::Status sent = core::Status::kNotReady;
  safety::Observation seen;
  safety::FailsafeCondition conditions{};
  ctl::LawReport law;
  std::optional<log::ExcitationRecord> excitation;  ///< from its start on
  T residual{0};  ///< of the worst channel of sysid::ResidualMonitor, over its expected value
  protocol::Telemetry telemetry;
  link::AuthorityView authority;
  link::LinkHealth health;
  link::PoseLinkStats poses;
  SourceFrame<T> source_frame;

  /// Pose and attitude that came in this tick replace those of before.
  void keep_newest(const est::Measurement<T>& came) {
    measured.pose = came.pose.is_new ? came.pose : measured.pose;
    measured.attitude = came.attitude.is_new ? came.attitude : measured.attitude;
    measured.pose.is_new = came.pose.is_new;
    measured.attitude.is_new = came.attitude.is_new;
  }
};

}  // namespace m100::app
