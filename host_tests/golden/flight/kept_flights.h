// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host_tests/golden/flight/flight_recording.h"
#include "host_tests/golden/flight/unlogged.h"

// A kept flight is the recorded input of the program and, second by second, the hash of what the program computed from
// it. A change of one bit in an estimate, in a command, in a byte on the wire or in an observation of the supervisor is
// seen. After an intended change the table is written anew (`kept_flights`), and the commit shows which flights it
// touches.
namespace m100::golden {

/// Two courses that together use every kind of piece that a trajectory has.
enum class KeptCourse : std::uint8_t { kSteps, kMinimumSnap };

struct KeptFlight {
  const char* name;  ///< also the name of its recording
  link::Channel channel = link::Channel::kVirtualRc;
  KeptCourse course = KeptCourse::kSteps;
  mpc::Law law = mpc::Law::kMpc;
  bool solves_when_due = false;
  bool excites = false;
};

/// record_kept.cpp says what happens in each flight, and when.
inline constexpr std::array kKeptFlights{
    KeptFlight{.name = "minimum_snap", .course = KeptCourse::kMinimumSnap},
    KeptFlight{.name = "movement", .channel = link::Channel::kMovement, .course = KeptCourse::kMinimumSnap},
    KeptFlight{.name = "gusts", .law = mpc::Law::kLqr},
    KeptFlight{.name = "losses", .solves_when_due = true},
    KeptFlight{.name = "sensor_fault"},
    KeptFlight{.name = "attitude_fault"},
    KeptFlight{.name = "storm"},
    KeptFlight{.name = "payload", .course = KeptCourse::kMinimumSnap},
    KeptFlight{.name = "bad_line", .channel = link::Channel::kMovement},
    KeptFlight{.name = "limit_cycle"},
    KeptFlight{.name = "excited", .excites = true},
};

/// The configuration of a kept flight. Its excitation moves each stick in turn right, left and right.
inline app::FlightConfig config_of(const KeptFlight& flight) {
  static constexpr std::array<std::int16_t, 30> kCounts = [] {
    std::array<std::int16_t, 30> counts{};
    for (std::size_t i = 0; i < counts.size(); ++i) {
      counts[i] = i < 8 || i >= 22 ? std::int16_t{60} : std::int16_t{-60};
    }
    return counts;
  }();
  static constexpr std::array<ctl::ExcitationPiece, 4> kPieces{{{ctl::ExcitedStick::kRoll, 0, 30},
                                                                {ctl::ExcitedStick::kPitch, 2, 26},
                                                                {ctl::ExcitedStick::kThrottle, 0, 24},
                                                                {ctl::ExcitedStick::kYaw, 4, 20}}};
  constexpr ctl::ExcitationLimits kLimits{.distance = 1.5, .braking = 1.5, .speed = 1.5, .tilt_rad = 0.35};
  app::FlightConfig config = app::kDefaultFlight;
  config.link.app_id = 1;
  config.link.channel.channel = flight.channel;
  config.law = flight.law;
  config.solves_when_due = flight.solves_when_due;
  config.fence = app::kBoardFence;
  config.reach_m = app::kBoardReach_m;
  if (flight.excites) {
    config.excitation = {.counts = kCounts, .pieces = kPieces, .limits = {kLimits, kLimits, kLimits, kLimits}};
  }
  return config;
}

/// Lays the course; it begins 1.5 m above the origin.
template <typename T>
core::Status lay_kept_course(KeptCourse kind, ref::Trajectory<T>& course) {
  using namespace std::chrono_literals;
  const auto place = [](double x_m, double y_m, double z_m, double yaw_rad) {
    return ref::Waypoint<T>{.position_w_m = {static_cast<T>(x_m), static_cast<T>(y_m), static_cast<T>(z_m)},
                            .yaw_rad = static_cast<T>(yaw_rad)};
  };
  course.hold(place(0.0, 0.0, 1.5, 0.0));
  std::array<core::Status, 5> said{};
  if (kind == KeptCourse::kSteps) {
    said = {course.append_step(place(0.0, 0.0, 1.5, 0.0), 1s), course.append_step(place(1.0, -0.5, 1.7, 0.4), 4s),
            course.append_step(place(-0.5, 1.0, 1.4, -0.6), 30s)};
  } else {
    const std::array<ref::Waypoint<T>, 2> snap{place(0.5, 0.5, 1.8, 0.5), place(0.0, 1.0, 1.5, 1.0)};
    const std::array<ref::TimedWaypoint<T>, 2> timed{
        {{.place = place(-0.5, 0.5, 1.3, 0.5), .at = 900ms}, {.place = place(0.0, 0.0, 1.5, 0.0), .at = 1900ms}}};
    const ref::SpeedLimits limits{};
    said = {course.append_quintic(place(0.4, -0.3, 1.6, -0.5), 1200ms), course.append_minimum_snap(snap, limits),
            course.append_timed(timed), course.append_curve(ref::Curve::figure_of_eight(1.5, 0.8, 1.0, 1.0), limits),
            course.append_square(T(0.6), 900ms, 200ms)};
  }
  for (const core::Status status : said) {
    if (status != core::Status::kOk) {
      return status;
    }
  }
  return core::Status::kOk;
}

/// The first 8 digits of both hashes (log; unlogged values) after each second and at the end; "incomplete" if there is
/// no hash.
template <typename T, typename S>
std::vector<std::string> seconds_of(const KeptFlight& kept, const std::filesystem::path& recording) {
  std::ifstream file(recording, std::ios::binary);
  const auto read = [&file](std::span<std::byte> into) {
    file.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
    return static_cast<std::size_t>(file.gcount());
  };
  const auto lay = [&kept](ref::Trajectory<T>& course) { return lay_kept_course(kept.course, course); };
  const auto flight = std::make_unique<ReplayedFlight<T, S>>(lay, config_of(kept));
  const auto tick = std::make_unique<RecordedTick>();
  std::vector<std::string> out;
  NumberHash unlogged;
  unsigned ticks = 0;
  const auto note = [&] {
    NumberHash beside = unlogged;
    const HashText logged = flight->so_far(), looked = beside.finish();
    out.push_back(logged[0] == '\0' ? "incomplete" : std::string(logged.data(), 8) + std::string(looked.data(), 8));
  };
  while (read_tick(*tick, read)) {
    flight->load(*tick);
    flight->tick();
    flight->drain();
    append_unlogged(unlogged, flight->controller());
    if (++ticks % 100 == 0) {
      note();
    }
  }
  note();
  return out;
}

/// The lines of the table, one per scalar type: flight, scalar, then the seconds.
inline std::vector<std::string> lines_of(const KeptFlight& kept, const std::filesystem::path& folder) {
  const std::filesystem::path recording = folder / (std::string(kept.name) + ".recording");
  const auto line = [&kept](const char* scalar, const std::vector<std::string>& seconds) {
    std::string out = std::string(kept.name) + " " + scalar;
    for (const std::string& second : seconds) {
      out += " " + second;
    }
    return out;
  };
  return {line("double", seconds_of<double, double>(kept, recording)),
          line("float", seconds_of<float, float>(kept, recording)),
          line("fixed", seconds_of<float, core::Fixed>(kept, recording))};
}

}  // namespace m100::golden
