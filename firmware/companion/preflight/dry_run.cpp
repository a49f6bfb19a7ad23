// SPDX-License-Identifier: BSD-3-Clause
// m100 fly --dry-run: reads, checks, listens, estimates and logs as a flight does, and sends nothing at all.
#include "firmware/companion/preflight/dry_run.h"

#include <iostream>
#include <memory>
#include <optional>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/log_file.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/fly/flight_files.h"
#include "firmware/companion/ground_station/telemetry_stream.h"
#include "firmware/companion/operator/line_writer.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/model_findings.h"
#include "firmware/companion/preflight/probe/receive_only_port.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

/// What a dry run finds out without sending.
struct ReceivedState {
  bool telemetry = false;
  bool mode_f = false;
  std::optional<bool> pose;  ///< no value: not examined
  link::LinkHealth health;
  Json pose_link{};
  std::uint32_t stalls = 0;
};

/// Calls `tick` every 10 ms until --hold is over or a signal comes. @returns the number of stalls.
template <typename Tick>
std::uint32_t listen(const FlyOptions& options, const std::function<void()>& before_time, const Tick& tick) {
  TickClock clock(options.port, before_time);
  for (core::TimePoint now = clock.now();
       core::seconds<double>(now.time_since_epoch()) < options.hold_s && !stop_requested(); now = clock.next()) {
    tick(now);
  }
  return clock.stalls();
}

/// Clears the session counts: the link's request for the version was never sent, so its missing answer is not a failure
/// of the line.
link::LinkHealth unasked(link::LinkHealth health) {
  health.sessions = {};
  return health;
}

/// Without a vehicle or a pose there is nothing to estimate: runs the link alone.
ReceivedState listen_only(const FlyOptions& options, const link::LinkConfig& config, hal::Uart& port) {
  link::SerialLink link(port, config);
  const std::uint32_t stalls = listen(
      options, [] {}, [&](core::TimePoint now) { link.receive(now); });
  return {.telemetry = link.authority().telemetry_fresh,
          .mode_f = link.authority().mode_f,
          .pose = {},
          .health = unasked(link.health()),
          .stalls = stalls};
}

/// Runs the flight controller without sending.
ReceivedState fly_silently(const FlyOptions& options, const FlightFiles& orders, const FlightModel& model,
                           const link::LinkConfig& link, hal::Uart& port) {
  PosePort pose_port(options.pose, options.port);
  const FlightPreparation prepared(pose_port, options, orders, link);
  ReceiveOnlyPort silent_pose_port(pose_port.line());
  std::optional<LogFile> log_file;
  log::FlightLogWriter* const log = begin_log(log_file, options, model, orders, prepared, core::TimePoint{});
  const auto controller = std::make_unique<app::FlightController<double>>(
      model.vehicle(), model.tables(), prepared.config, port, silent_pose_port, *prepared.course, log);
  TelemetryStream stream(options.live, nullptr, {});
  LineWriter writer(shows_status(options.live));
  const auto mark_poses = [&] { pose_port.mark_arrived(); };
  const std::uint32_t stalls = listen(options, mark_poses, [&](core::TimePoint now) {
    pose_port.tick();
    (void)controller->tick(now);
    stream.publish(controller->record(), 0);
    writer.show(controller->record());
  });
  const est::Estimate<double>& estimate = controller->estimate();
  return {.telemetry = controller->link().authority().telemetry_fresh,
          .mode_f = controller->link().authority().mode_f,
          .pose = estimate.healthy && controller->observed().estimate.pose_age <=
                                          fresh_limit(prepared.config.limits, controller->observed().pose_latency),
          .health = unasked(controller->link().health()),
          .pose_link = companion::to_json(controller->pose_link().stats(), pose_port.signatures()),
          .stalls = stalls};
}

void print_result(const FlyOptions& options, const ReceivedState& seen) {
  std::cout << "autopilot: " << (seen.telemetry ? "telemetry comes" : "no telemetry; m100 probe tells why") << "\n";
  if (seen.telemetry) {
    std::cout << "switch:    "
              << (seen.mode_f ? "at F" : "not at F: control would be refused; set the transmitter's mode switch to F")
              << "\n";
  }
  if (seen.pose) {
    std::cout << "pose:      "
              << (*seen.pose ? "fresh, and the estimate is healthy" : "too old, or the estimate is not healthy")
              << "\n";
  }
  print(std::cout, seen.health);
  Json out{{"dry_run", true},
           {"channel", options.channel},
           {"baud", options.baud},
           {"obtained", false},
           {"released", false},
           {"telemetry", seen.telemetry},
           {"mode_f", seen.mode_f},
           {"stalls", seen.stalls},
           {"bytes_sent", seen.health.bytes_sent},
           {"health", companion::to_json(seen.health)}};
  if (seen.pose) {
    out["pose"] = *seen.pose;
    out["pose_link"] = seen.pose_link;
  }
  write_result(options.json, out);
}

}  // namespace

bool dry_run(const FlyOptions& options, const link::LinkConfig& link, hal::Uart& autopilot) {
  std::cout << "dry run: nothing is sent to the autopilot" << std::endl;
  const FlightFiles orders(options);
  const bool has_model = !options.vehicle.empty() && !options.gains.empty();
  if (options.vehicle.empty() != options.gains.empty()) {
    throw UsageError("fly: --vehicle and --gains must be given together");
  }
  if (!options.log.empty() && (!has_model || options.pose.port.empty())) {
    throw UsageError("fly: --log needs --pose-port, --vehicle and --gains");
  }
  std::optional<FlightModel> model;
  if (has_model) {
    model.emplace(sound_model(options, orders.mode));
  }
  ReceiveOnlyPort port(autopilot);
  ReceivedState seen;
  if (model && !options.pose.port.empty()) {
    seen = fly_silently(options, orders, *model, link, port);
  } else {
    check_offsets(orders);
    seen = listen_only(options, link, port);
  }
  print_result(options, seen);
  return seen.telemetry && seen.pose.value_or(true);
}

}  // namespace m100::companion
