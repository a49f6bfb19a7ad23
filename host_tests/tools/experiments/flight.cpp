// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/experiments/flight.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>

#include "firmware/app/course.h"
#include "firmware/app/replay.h"
#include "host_tests/tools/gains/write_tables.h"

namespace m100::tools::experiments {
namespace {

using Controller = app::FlightController<double>;
constexpr core::Duration kMostStartUp = std::chrono::seconds(30);
constexpr core::Duration kHandOver = std::chrono::seconds(4);
constexpr std::size_t kLogRingBytes = 1U << 18U;

app::FlightConfig config_of(const FlightPlan& plan) {
  app::FlightConfig config;
  config.link.channel.channel = plan.channel;
  config.link.channel.rate_hz = plan.rate_hz;
  config.link.channel.paper_100_hz = plan.paper_100_hz;
  config.link.app_id = 1;
  config.link.baud = static_cast<std::uint32_t>(plan.plant.link.baud);
  return config;
}

/// The ring that a flight's log goes through, and what came out of it.
class LogSink {
 public:
  explicit LogSink(bool keep) : storage_(keep ? kLogRingBytes : 1), ring_(storage_), log_(ring_) {}
  log::FlightLog& log() { return log_; }
  void drain(std::vector<std::uint8_t>& into) {
    while (!ring_.front().empty()) {
      const std::span<const std::byte> piece = ring_.front();
      const auto* const first = reinterpret_cast<const std::uint8_t*>(piece.data());
      into.insert(into.end(), first, first + piece.size());
      ring_.pop(piece.size());
    }
  }

 private:
  std::vector<std::byte> storage_;
  log::Ring ring_;
  log::FlightLog log_;
};

/// Everything that one flight needs, in the order in which it must be made.
class Flight {
 public:
  explicit Flight(const FlightPlan& plan)
      : plan_(plan),
        vehicle_text_(app::to_text(plan.vehicle.vehicle, plan.vehicle.sources)),
        tables_(gains::make_gain_tables(plan.vehicle.vehicle, app::parse_vehicle(vehicle_text_, "vehicle").digest)),
        world_(plan.plant, {.seed = plan.seed}),
        sink_(plan.keep_log) {
    start_.position_w_m = world_.vehicle().state().position_w_m;
    app::lay_course(plan.course, start_, trajectory_);
    if (plan.keep_log) {
      begin_log();
    }
    controller_ = std::make_unique<Controller>(plan.vehicle.vehicle, tables_, config_of(plan), world_.autopilot_uart(),
                                               world_.pose_uart(), trajectory_, plan.keep_log ? &sink_.log() : nullptr);
  }

  FlightResult run() {
    if (!obtain()) {
      return finish();
    }
    result_.flew = true;
    const core::TimePoint begin = controller_->started();
    const auto end = begin + core::Duration(static_cast<std::int64_t>(plan_.duration_s * 1e6));
    while (world_.now() < end) {
      const double t_s = core::seconds<double>(world_.now() - begin);
      if (plan_.disturb) {
        plan_.disturb(world_, t_s);
      }
      note(t_s);
      tick();
    }
    controller_->release();
    for (const core::TimePoint last = world_.now() + kHandOver; world_.now() < last;) {
      tick();
    }
    result_.handed_over = !world_.autopilot().client_in_control() && !world_.autopilot().virtual_rc_on();
    return finish();
  }

 private:
  /// All that a replay needs beside the bytes.
  void begin_log() {
    const gains::TableSet set{.tables = tables_, .x = {}, .y = {}};
    const std::vector<std::byte> tables = gains::to_file(set);
    std::ostringstream start;
    start.precision(17);
    start << start_.position_w_m.x() << " " << start_.position_w_m.y() << " " << start_.position_w_m.z() << " "
          << start_.yaw_rad;
    const std::string channel = std::string(plan_.channel == app::Channel::kMovement ? "movement" : "virtual_rc") +
                                (plan_.paper_100_hz ? " paper_100_hz" : "");
    const std::string place = start.str();
    const std::array notes{
        log::Note{app::kVehicleNote, vehicle_text_},
        log::Note{app::kTablesNote, std::string_view(reinterpret_cast<const char*>(tables.data()), tables.size())},
        log::Note{app::kCourseNote, plan_.course}, log::Note{app::kStartNote, place},
        log::Note{app::kChannelNote, channel}};
    M100_ASSERT(sink_.log().begin(core::TimePoint{}, notes) == core::Status::kOk);
  }

  void tick() {
    world_.advance(core::kTickPeriod);
    static_cast<void>(controller_->tick(world_.now()));
    sink_.drain(result_.log);
    const core::Euler<double>& attitude = world_.vehicle().attitude();
    const double tilt_deg =
        std::acos(std::cos(attitude.roll_rad) * std::cos(attitude.pitch_rad)) * 180.0 / std::numbers::pi;
    result_.largest_tilt_deg = std::max(result_.largest_tilt_deg, tilt_deg);
  }

  /// Start-up over the wire, then the operator's order, until the ladder is at its top.
  bool obtain() {
    bool ordered = false;
    for (const core::TimePoint last = world_.now() + kMostStartUp; world_.now() < last;) {
      tick();
      const bool ready = controller_->link().authority().stage == safety::Stage::kReady;
      if (ready && !ordered) {
        controller_->engage();
        ordered = true;
      }
      if (controller_->grant().rung == safety::Rung::kNominal) {
        return true;
      }
    }
    return false;
  }

  void note(double t_s) {
    const sim::VehicleState& truth = world_.vehicle().state();
    const core::Euler<double>& attitude = world_.vehicle().attitude();
    const ref::Window<double> reference = trajectory_.window(world_.now(), core::Duration{0});
    const safety::Grant<double>& grant = controller_->grant();
    TracePoint point;
    point.t_s = t_s;
    point.reference_m = {reference.x[0].position_m, reference.y[0].position_m, reference.height.position_m};
    point.position_m = {truth.position_w_m.x(), truth.position_w_m.y(), truth.position_w_m.z()};
    point.velocity_m_s = {truth.velocity_w_m_s.x(), truth.velocity_w_m_s.y(), truth.velocity_w_m_s.z()};
    point.reference_yaw_rad = reference.yaw_rad;
    point.yaw_rad = attitude.yaw_rad;
    point.roll_rad = attitude.roll_rad;
    point.pitch_rad = attitude.pitch_rad;
    point.granted = {grant.command.roll_rad, grant.command.pitch_rad, grant.command.climb_m_s,
                     grant.command.yaw_rate_rad_s};
    point.disturbance_m_s2 = {controller_->estimate().x.disturbance_m_s2, controller_->estimate().y.disturbance_m_s2};
    point.rung = static_cast<int>(grant.rung);
    result_.trace.push_back(point);
  }

  FlightResult finish() {
    result_.hardest_touch_m_s = world_.vehicle().hardest_touch_m_s();
    result_.ticks = controller_->stats();
    result_.autopilot = world_.autopilot().record();
    result_.dropped_log_messages = plan_.keep_log ? sink_.log().dropped() : 0;
    return std::move(result_);
  }

  const FlightPlan& plan_;
  std::string vehicle_text_;
  mpc::GainTables<double> tables_;
  sim::World world_;
  ref::Trajectory<double> trajectory_;
  ref::Waypoint<double> start_;
  LogSink sink_;
  std::unique_ptr<Controller> controller_;
  FlightResult result_;
};

}  // namespace

FlightResult fly(const FlightPlan& plan) {
  const auto before = std::chrono::steady_clock::now();
  FlightResult result = Flight(plan).run();
  result.seconds_of_computer = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  return result;
}

}  // namespace m100::tools::experiments
