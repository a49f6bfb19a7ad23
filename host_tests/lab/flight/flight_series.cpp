// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/flight_series.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/replay/replay.h"
#include "host_tests/lab/flight/recording_series.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::flight {
namespace {

using Controller = app::FlightController<double>;
using companion::RecordedFlight;

double seconds_of(const log::TickRecord& record, const log::TickRecord& first) {
  return 1e-6 * static_cast<double>(record.timestamp - first.timestamp);
}

/// The vehicle file of the flight. An older log may hold none that this version reads.
std::optional<model::Vehicle> vehicle_of(const RecordedFlight& flight) {
  const auto note = flight.notes.find(companion::kVehicleNote);
  if (note == flight.notes.end()) {
    return {};
  }
  try {
    return companion::parse_vehicle(note->second, note->first).vehicle;
  } catch (const std::runtime_error&) {
    return {};
  }
}

void add_tick(const log::TickRecord& record, double t_s, FlightSeries& out) {
  out.t_s.push_back(t_s);
  for (std::size_t i = 0; i < 3; ++i) {
    out.position_m[i].push_back(record.position[i]);
    out.reference_m[i].push_back(record.ref_position[i]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    out.granted[i].push_back(record.granted[i]);
    if (record.sent != 0) {
      out.sticks_counts[i].t_s.push_back(t_s);
      out.sticks_counts[i].values.push_back(static_cast<double>(record.sticks[i]) - 1024.0);
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    out.disturbance_m_s2[i].push_back(record.disturbance[i]);
  }
  out.residual.push_back(static_cast<double>(record.residual));
  out.telemetry_age_s.push_back(static_cast<double>(record.telemetry_age));
  out.late_s.push_back(static_cast<double>(record.late));
  out.state.push_back(record.state);
  if (record.imu_new != 0) {
    out.attitude_t_s.push_back(t_s);
    for (std::size_t i = 0; i < 3; ++i) {
      out.attitude_rad[i].push_back(record.imu_attitude[i]);
    }
  }
  if (record.pose_new != 0) {
    out.poses.push_back({t_s, t_s - static_cast<double>(record.pose_age), record.pose_position});
  }
  out.refused_poses += record.pose_new != 0 && record.refused_poses > 0 ? 1U : 0U;
}

bool is_law(std::uint8_t state) { return safety::passes_law(static_cast<safety::FailsafeState>(state)); }

/// When the law flew, and the steps of the failsafe without their reasons.
void find_states(FlightSeries& out) {
  bool has_flown = false;
  for (std::size_t k = 0; k < out.state.size(); ++k) {
    const auto now = static_cast<safety::FailsafeState>(out.state[k]);
    const auto before = k > 0 ? static_cast<safety::FailsafeState>(out.state[k - 1]) : safety::FailsafeState::kSilent;
    if (now != before) {
      out.changes.push_back(
          {out.t_s[k], std::string(safety::name(before)), std::string(safety::name(now)), std::string()});
    }
    if (is_law(out.state[k])) {
      out.control_s = has_flown ? out.control_s : out.t_s[k];
      out.end_s = out.t_s[k];
      has_flown = true;
    }
  }
}

/// Adds the percentage when it changes, and at the end; 0 is left out.
void add_battery(std::uint8_t percent, double t_s, bool is_last, Timed& battery) {
  if (percent > 0 && (battery.values.empty() || battery.values.back() != percent || is_last)) {
    battery.t_s.push_back(t_s);
    battery.values.push_back(percent);
  }
}

/// Shifts a tick's horizontal reference, which leads by the delay that the law predicts through, to the tick's time.
void remove_lead(double lead_s, FlightSeries& out) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const std::vector<double> leading = out.reference_m[axis];
    std::size_t at = 0;
    for (std::size_t k = 0; k < out.t_s.size(); ++k) {
      while (at + 1 < k && out.t_s[at + 1] <= out.t_s[k] - lead_s) {
        ++at;
      }
      const std::size_t next = std::min(at + 1, k);
      const double step_s = out.t_s[next] - out.t_s[at];
      const double share = step_s > 0.0 ? std::clamp((out.t_s[k] - lead_s - out.t_s[at]) / step_s, 0.0, 1.0) : 0.0;
      out.reference_m[axis][k] = leading[at] + share * (leading[next] - leading[at]);
    }
  }
}

/// Adds what only the replayed flight code knows. @returns the law's lead [s]; none: the log cannot be replayed.
std::optional<double> add_replay(const RecordedFlight& flight, const protocol::Cipher* cipher, FlightSeries& out) {
  std::uint32_t steps = 0;
  std::size_t tick = 0;
  double lead_s = 0.0;
  std::vector<std::string> reasons;
  const auto observe = [&](const Controller& controller) {
    if (controller.supervisor().stats().steps != steps) {
      steps = controller.supervisor().stats().steps;
      reasons.emplace_back(safety::name(controller.supervisor().last_step().reason));
    }
    const double t_s = out.t_s[tick];
    const bool is_last = ++tick == flight.ticks.size();
    lead_s = core::seconds<double>(controller.law().lead());
    const est::VibrationStatus& vibration = controller.observed().consistency.vibration;
    out.vibration_m_s2.push_back(vibration.rms_m_s2);
    out.vibration_peak_m_s2.push_back(vibration.peak_m_s2);
    add_battery(controller.link().telemetry().battery_percent, t_s, is_last, out.battery_percent);
    if (is_last) {
      const link::PoseLinkStats& stats = controller.pose_link().stats();
      const double received = static_cast<double>(stats.poses) + stats.refused + stats.refused_order;
      out.lost_share = received > 0.0 ? stats.lost_frames / (received + stats.lost_frames) : -1.0;
      out.refused_poses += stats.refused + stats.refused_order;
    }
  };
  try {
    const companion::ReplayResult result = companion::replay(flight, cipher, observe);
    if (result.different_ticks > 0) {
      out.notes.push_back("The replay differs from the log in " + std::to_string(result.different_ticks) + " of " +
                          std::to_string(result.ticks) +
                          " ticks: reasons, battery and losses are what this version of the program finds.");
    }
  } catch (const std::runtime_error& wrong) {
    out.notes.push_back(std::string("The log cannot be replayed (") + wrong.what() +
                        "): reasons, battery, losses and vibration are missing.");
    out.vibration_m_s2.clear();
    return {};
  }
  for (std::size_t i = 0; reasons.size() == out.changes.size() && i < reasons.size(); ++i) {
    out.changes[i].reason = reasons[i];
  }
  return lead_s;
}

/// Half a second to each side of a tick: shorter windows show the noise of the poses, longer ones no gust.
constexpr double kHalf_s = 0.5;

/// Place, velocity and acceleration along one axis: a parabola fitted to the poses in the window around now_s, of which
/// `first` is the first. Empty: too few poses.
std::optional<Eigen::Vector3d> fit_motion(const std::vector<Pose>& poses, std::size_t first, double now_s,
                                          std::size_t axis) {
  constexpr std::size_t kMinPoses = 10;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = first; i < poses.size() && poses[i].captured_s <= now_s + kHalf_s; ++i, ++count) {
    const double s = poses[i].captured_s - now_s;
    const Eigen::Vector3d row(1.0, s, 0.5 * s * s);
    normal += row * row.transpose();
    right += row * poses[i].position_m[axis];
  }
  return count < kMinPoses ? std::nullopt : std::optional<Eigen::Vector3d>(normal.ldlt().solve(right));
}

/// The mean acceleration along one axis by the tilt in the window around now_s, of which `begin` is the first tick.
double tilt_acceleration(const RecordedFlight& flight, const FlightSeries& out, std::size_t begin, double now_s,
                         std::size_t axis, double tilt_gain) {
  double slope = 0.0;
  double ticks = 0.0;
  for (std::size_t i = begin; i < out.t_s.size() && out.t_s[i] <= now_s + kHalf_s; ++i, ticks += 1.0) {
    const std::array<double, 3>& tilt = flight.ticks[i].record.attitude;
    slope += axis == 0 ? std::tan(tilt[1]) : -std::tan(tilt[0]);
  }
  return tilt_gain * model::kGravity_m_s2 * slope / ticks;
}

/// The acceleration that the poses around each tick show, minus what tilt and drag explain.
void add_found_disturbance(const RecordedFlight& flight, const model::Vehicle& vehicle, FlightSeries& out) {
  std::size_t first = 0;
  std::size_t begin = 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    out.found_disturbance_m_s2[axis].assign(out.t_s.size(), std::nan(""));
  }
  for (std::size_t k = 0; k < out.t_s.size(); ++k) {
    const double now = out.t_s[k];
    while (first < out.poses.size() && out.poses[first].captured_s < now - kHalf_s) {
      ++first;
    }
    while (out.t_s[begin] < now - kHalf_s) {
      ++begin;
    }
    if (now < kHalf_s || now + kHalf_s > out.t_s.back()) {
      continue;
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (const std::optional<Eigen::Vector3d> motion = fit_motion(out.poses, first, now, axis)) {
        model::Moment moment;
        moment.air_velocity_w_m_s[axis] = (*motion)(1);
        out.found_disturbance_m_s2[axis][k] =
            (*motion)(2) - tilt_acceleration(flight, out, begin, now, axis, vehicle.translation.tilt_gain) -
            model::outer_acceleration(vehicle.translation, moment, 1.0)[axis];
      }
    }
  }
}

void add_fence(const RecordedFlight& flight, FlightSeries& out) {
  const auto file = flight.notes.find(companion::kFlightNote);
  const auto start = flight.notes.find(companion::kStartNote);
  if (file == flight.notes.end() || start == flight.notes.end()) {
    return;
  }
  std::istringstream words(start->second);
  ref::Waypoint<double> from;
  words >> from.position_w_m.x() >> from.position_w_m.y() >> from.position_w_m.z();
  try {
    out.fence = companion::fence_of(companion::parse_flight(file->second, file->first), from);
  } catch (const companion::FileError& wrong) {
    out.notes.emplace_back(wrong.what());
  }
}

}  // namespace

FlightSeries series_of(const RecordedFlight& flight, const std::string& name, const protocol::Cipher* cipher) {
  FlightSeries out;
  out.name = name;
  for (const RecordedFlight::Tick& tick : flight.ticks) {
    add_tick(tick.record, seconds_of(tick.record, flight.ticks.front().record), out);
  }
  find_states(out);
  out.tilt_limit_rad = app::kDefaultFlight.envelope.tilt_rad;
  add_fence(flight, out);
  const std::optional<double> lead_s = add_replay(flight, cipher, out);
  const std::optional<model::Vehicle> vehicle = vehicle_of(flight);
  remove_lead(lead_s.value_or(vehicle ? model::controller_model(*vehicle).pitch.transport_delay_s : 0.0), out);
  if (vehicle) {
    add_found_disturbance(flight, *vehicle, out);
  }
  return out;
}

FlightSeries read_series(const std::string& file, const protocol::Cipher* cipher) {
  const std::unique_ptr<logs::RawLog> raw = logs::open_log(file);
  const std::vector<logs::TopicSummary> topics = raw->topics();
  const auto has = [&](const char* name) {
    return std::any_of(topics.begin(), topics.end(), [&](const auto& topic) { return topic.name == name; });
  };
  const std::string name = std::filesystem::path(file).filename().string();
  if (has("tick")) {
    try {
      const RecordedFlight flight = companion::read_flight(file);
      if (flight.ticks.empty()) {
        throw InputError(file, 0, "", "holds no complete tick");
      }
      return series_of(flight, name, cipher);
    } catch (const companion::FlightLogError& wrong) {
      throw InputError(file, 0, "", wrong.what());
    }
  }
  if (!has("rc") && !has("attitude")) {
    throw InputError(file, 0, "",
                     "is neither a log of 'm100 fly' nor a recording of 'm100 record'; 'm100-lab logs' lists what it "
                     "holds");
  }
  return recording_series(*raw, name);
}

}  // namespace m100::lab::flight
