// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/source_frame.h"
#include "firmware/core/frames.h"
#include "firmware/core/time.h"
#include "firmware/est/timing/pose_timing.h"
#include "firmware/link/pose/pose_link.h"
#include "firmware/safety/limits.h"
#include "hal/uart.h"

namespace m100::app {

/// The poses: from their UART to one pose a tick, with the time of its capture. T is float or double.
template <typename T>
class PoseInput {
 public:
  /// @param tap may be null.
  /// @param from whose poses are used.
  PoseInput(hal::Uart& uart, std::uint32_t baud, link::ByteTap* tap, link::SenderChoice from,
            const link::PoseProperties& properties)
      : link_(uart, baud, tap, from, properties) {}

  /// @param stalled the tick comes after a stall: then waiting poses are dropped, because they are older than they seem
  ///   by an unknown time. @returns the newest pose; is_new is false if none came or was used.
  core::Pose<double> receive(bool stalled, core::TimePoint now) {
    const core::Expected<core::Pose<double>> came = link_.receive(now);
    link_.request_time(now);
    if (stalled) {
      for (int backlog = 0; backlog < kBacklogReads && link_.receive(now); ++backlog) {
      }
      return {};
    }
    return came ? *came : core::Pose<double>{};
  }

  /// Brings a new pose into the flight's world. @param estimate of the tick before.
  /// @returns whether the source's world has moved.
  bool enter_flight(core::Pose<T>& pose, const est::Estimate<T>& estimate, core::TimePoint now) {
    return pose.is_new && source_.update(pose, link_.stats().announced_jumps, estimate, timing().unreported, now);
  }
  /// Sets the time of capture. @param heading as estimated in the tick before.
  void date(est::Measurement<T>& measured, const core::SinCos<T>& heading) { timing_.update(measured, heading); }

  const SourceFrame<T>& source_frame() const { return source_; }
  const link::PoseLink& link() const { return link_; }
  const est::PoseTimingReport<T>& timing() const { return timing_.report(); }
  safety::MeasuredLatency latency() const {
    const est::PoseTimingReport<T>& timing = timing_.report();
    return {.min_latency = timing.min_latency, .jitter = timing.jitter, .interval = timing.interval};
  }

 private:
  static constexpr int kBacklogReads = 32;  ///< of PoseLink::kBytesPerTick: more than a driver holds

  link::PoseLink link_;
  est::PoseTiming<T> timing_;
  SourceFrame<T> source_;
};

}  // namespace m100::app
