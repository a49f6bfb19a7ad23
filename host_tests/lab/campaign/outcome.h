// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "host_tests/lab/campaign/tasks.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::lab::campaign {

/// The results that a campaign keeps of one flight.
struct Outcome {
  bool scored = false;  ///< the course was flown for at least one tick, so that the errors and rates below are valid
  bool stayed = false;  ///< never below coast and always inside the fence until the task was over
  bool coasted = false;
  bool released = false;  ///< control was given back before the task was over
  bool breached = false;  ///< outside the fence before the task ended, at most 2 s after a handover
  bool oscillated = false;
  double limit_cycle_detected_s = -1.0;  ///< from the start of the course; negative: none was detected
  bool contradicted = false;             ///< this and the next two as in experiments::FlightResult
  bool model_mismatch = false;
  std::uint32_t refused_poses = 0;
  double latency_error_s = 0.0;   ///< estimated minus true age of the poses at the end, counted from capture
  double latency_sigma_s = 0.0;   ///< the standard deviation that the observer claims for it
  double handed_over_m_s = -1.0;  ///< horizontal speed when the pilot got the sticks; negative: he did not
  double worst_tilt_deg = 0.0;    ///< of the thrust axis, on the course, until the task ends or 2 s after a handover
  double pose_rms_m = 0.0;        ///< distance from the reference, until the task was over or the flight failed
  double tilt_rms_deg = 0.0;      ///< over the same time
  double command_deg_s = 0.0;     ///< summed change of both tilt commands per second
  double nees_sum = 0.0;          ///< over the ticks before a failure that have one; the expectation is 4 for each
  std::uint32_t nees_count = 0;
  double nis_sum = 0.0;  ///< over the poses used; the expectation is 2 for each; 0 unless the flight stayed
  std::uint32_t nis_count = 0;
  double failed_at_s = 0.0;  ///< from the start of the course
  std::string why;           ///< empty: it stayed
};

/// How all flights of a campaign are flown.
struct Settings {
  experiments::FlightPlan plan;  ///< what they have in common; world and task give the rest
  bool paper_law = false;        ///< flies experiments::in_paper_configuration()
  sim::BodyChoice
      body{};  ///< the aircraft of every flight but the reference flights, which the identified response flies
};

/// Flies one task in a world. The identified response gives the same outcome, bit for bit, whatever other threads fly.
/// @param body made from settings.body, for this thread alone; null: the identified response
Outcome fly_one(const sim::Plant& world, const Task& task, std::uint64_t seed, const Settings& settings,
                sim::BodyJob* body = nullptr);

/// Flies the task as fly_one does. @returns the flight's log, in the bytes of a ULog file; empty: it never flew
std::string log_of(const sim::Plant& world, const Task& task, std::uint64_t seed, const Settings& settings,
                   sim::BodyJob* body = nullptr);

/// The world of the reference flight of the oscillation check: the measured plant in this world's air, with its mass,
/// payload and change; source of pose, sensors and link have their defaults.
sim::Plant nominal_world(const sim::Plant& world);

}  // namespace m100::lab::campaign
