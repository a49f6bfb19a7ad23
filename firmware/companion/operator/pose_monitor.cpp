// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/pose_monitor.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

constexpr double kUpMean = 1.0 / 16.0;       // per tick, as in link::PoseLink
constexpr double kKnowsNoTilt = 1.0 - 1e-6;  // of a source that sends its heading only

double tilt_of(const core::Vector<double, 3>& up_b) { return std::acos(std::clamp(up_b.normalized().z(), -1.0, 1.0)); }

void add_sender(TextLine& line, const link::PoseSenders& senders, mavlink::Address from) {
  line.add("system ").add(from.system, 0).add(" component ").add(from.component, 0);
  if (const link::PoseSenders::Sender* const sender = senders.find(from)) {
    line.add(" (").add(sender->rate_hz(), 1).add(" poses a second)");
  }
}

}  // namespace

void PoseMonitor::tick(core::TimePoint now, const app::FlightController<double>& controller, bool waits,
                       OperatorLog& listener) {
  clock_steps_.update(now, controller.pose_timing(), listener);
  watch_rate(now, controller.pose_link(), listener);
  watch_rival(now, controller, waits, listener);
  if (!waits) {
    failed_ = false;
    looks_since_ = now;
    return;
  }
  watch_tilt(now, controller);
  if (controller.observed().consistency.contradicted_by != 0) {
    const core::Duration took = now - looks_since_;
    hold_ = failed_ ? hold_ : std::max(kHold, 4 * took);
    failed_ = true;
    failed_at_ = now;
  }
}

/// Judges the rate once, over the first seconds: the failsafe judges later gaps.
void PoseMonitor::watch_rate(core::TimePoint now, const link::PoseLink& pose, OperatorLog& listener) {
  constexpr core::Duration kJudged = std::chrono::seconds(2);
  const link::PoseSenders::Sender* const sender = pose.senders().find(pose.sender());
  if (rate_judged_ || sender == nullptr || sender->last - sender->first < kJudged) {
    return;
  }
  rate_judged_ = true;
  if (sender->rate_hz() < kMinPoses_hz) {
    TextLine line;
    line.add("poses come ").add(sender->rate_hz(), 0).add(" times a second, fewer than ").add(kMinPoses_hz, 0);
    listener.write(now, line.add(": send 50 or more, or a failure of the source is noticed later").text());
  }
}

void PoseMonitor::watch_rival(core::TimePoint now, const app::FlightController<double>& controller, bool waits,
                              OperatorLog& listener) {
  const link::PoseSenders::Sender* const rival = controller.pose_link().rival(now);
  rival_ = rival != nullptr;
  if (rival_ && !waits && !rival_said_) {
    rival_said_ = true;
    TextLine line;
    add_sender(line.add("poses of a second sender come and are not used: "), controller.pose_link().senders(),
               rival->from);
    listener.write(now, line.text());
  }
}

/// Compares the pose's attitude with the autopilot's by the direction of up in the body, which no heading changes.
void PoseMonitor::watch_tilt(core::TimePoint now, const app::FlightController<double>& controller) {
  const protocol::Telemetry& telemetry = controller.link().telemetry();
  const core::Vector<double, 3> pose_up_b = controller.pose_link().up_b().cast<double>();
  if (!telemetry.has(protocol::TelemetryItem::kAttitude) || pose_up_b.isZero(0.0)) {
    tilted_since_ = now;
    return;
  }
  const auto& q = telemetry.attitude;
  const core::Vector<double, 3> up_b = core::up_in_body(core::flip_yz(core::Quaternion<double>{
      static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]), static_cast<double>(q[3])}));
  up_b_ += (up_b - up_b_) * (up_b_.isZero(0.0) ? 1.0 : kUpMean);
  pose_tilt_rad_ = tilt_of(pose_up_b);
  autopilot_tilt_rad_ = tilt_of(up_b_);
  const bool knows_tilt = pose_up_b.normalized().z() < kKnowsNoTilt;
  tilt_apart_rad_ = knows_tilt ? std::acos(std::clamp(pose_up_b.normalized().dot(up_b_.normalized()), -1.0, 1.0)) : 0.0;
  tilted_since_ = tilt_apart_rad_ > kMaxTilt_rad ? tilted_since_ : now;
}

void PoseMonitor::describe(TextLine& line, const app::FlightController<double>& controller, core::TimePoint now) const {
  const link::PoseLink& pose = controller.pose_link();
  if (rival_) {
    add_sender(line.add("poses come from several senders: "), pose.senders(), pose.sender());
    if (const link::PoseSenders::Sender* const rival = pose.rival(now)) {
      add_sender(line.add(" and "), pose.senders(), rival->from);
    }
    line.add(": choose one with --pose-from SYS:COMP, or with 'from' in the flight file's [pose]");
  } else if (is_tilted(now)) {
    line.add("the pose says tilted by ").add(pose_tilt_rad_ / core::kDegree_rad, 0).add(" deg, the autopilot ");
    line.add(autopilot_tilt_rad_ / core::kDegree_rad, 0).add(" deg: quaternion order (w x y z) or body axes (");
    line.add(tilt_apart_rad_ / core::kDegree_rad, 0).add(" deg apart)");
  } else {
    line.add("a check of the pose against the autopilot failed; it must hold for ");
    line.add(core::seconds<double>(hold_), 0).add(" s, and has for ");
    line.add(core::seconds<double>(now - failed_at_), 0).add(" s: check the source of pose");
  }
}

}  // namespace m100::companion
