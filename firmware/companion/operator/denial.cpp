// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/denial.h"

namespace m100::companion {

using safety::FailsafeReason;

FailsafeReason denial_reason(const safety::Observation& seen, const safety::Limits& limits) {
  if (seen.link.telemetry_age > limits.telemetry_stale) {
    return FailsafeReason::kTelemetryOld;
  }
  if (seen.flight.failure != safety::FlightFailure::kNone) {
    return FailsafeReason::kFlightFailure;
  }
  if (seen.estimate.healthy && seen.consistency.refused_for >= limits.gate_shut) {
    return FailsafeReason::kPoseRefused;
  }
  if (seen.estimate.pose_age > fresh_limit(limits, seen.pose_latency)) {
    return FailsafeReason::kPoseOld;
  }
  if (!seen.estimate.healthy) {
    return FailsafeReason::kEstimateLost;
  }
  const bool flies = seen.flight.on_ground_for == core::Duration{0};  // after a flight the idling rotors shake
  if (flies && hides_false_poses(limits, seen.consistency.vibration.velocity_sigma_m_s)) {
    return FailsafeReason::kVibration;
  }
  if (seen.fence.outside_m > 0.0) {
    return FailsafeReason::kFenceLeft;
  }
  return seen.flight.on_ground_for >= limits.on_ground ? FailsafeReason::kOnGround : FailsafeReason::kNone;
}

std::string_view remedy_for(FailsafeReason denial_reason) {
  switch (denial_reason) {
    case FailsafeReason::kFenceLeft:
      return "bring the aircraft inside, or take a larger fence";
    case FailsafeReason::kOnGround:
      return "take off first";
    case FailsafeReason::kFlightFailure:
    case FailsafeReason::kVibration:
      return "check the aircraft";
    case FailsafeReason::kTelemetryOld:
    case FailsafeReason::kTelemetrySilent:
      return "check the cable and the autopilot's telemetry";
    case FailsafeReason::kPoseRefused:
    case FailsafeReason::kEstimateLost:
      return "check the likeliest cause first";
    default:
      return "check the source of pose";
  }
}

}  // namespace m100::companion
