// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/flight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>
#include <vector>

#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/replay/replay.h"
#include "firmware/core/maths.h"
#include "firmware/model/default_vehicle.h"
#include "host_tests/lab/experiments/flight_file_text.h"
#include "host_tests/lab/gains/write_tables.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::experiments {
namespace {

using Controller = app::FlightController<double>;
constexpr core::Duration kMaxStartUp = std::chrono::seconds(30);
constexpr core::Duration kHandOver = std::chrono::seconds(4);
constexpr std::size_t kLogRingBytes = 1U << 18U;

app::FlightConfig config_of(const FlightPlan& plan, const ref::Waypoint<double>& start) {
  app::FlightConfig config;
  config.link.channel.channel = plan.channel;
  config.link.channel.rate_hz = plan.rate_hz;
  config.link.channel.paper_100_hz = plan.paper_100_hz;
  config.link.app_id = 1;
  config.law = plan.law;
  config.excitation = plan.excitation;
  config.responds_to_limit_cycles = plan.responds_to_limit_cycles;
  config.plans_setpoints = plan.plans_setpoints;
  config.paper_law = plan.paper_law;
  config.solves_when_due = plan.solves_when_due;
  config.link.baud = static_cast<std::uint32_t>(plan.plant.link.baud);
  if (plan.flight_file) {
    config.limits = companion::limits_of(*plan.flight_file);
    config.fence = companion::fence_of(*plan.flight_file, start);
  }
  return config;
}

sim::WorldOptions world_of(const FlightPlan& plan, sim::VehiclePort* body) {
  sim::WorldOptions options{.seed = plan.seed};
  options.autopilot.pilot_holds_position = plan.pilot_holds_position || body != nullptr;
  options.body = body;
  return options;
}

/// error' P^-1 error of position and velocity of one axis, with the observer's own P; negative: it has none.
double normalised_square(const est::AxisEstimate<double>& axis, double position_m, double velocity_m_s) {
  const double pp = axis.position_variance_m2;
  const double pv = axis.position_velocity_m2_s;
  const double vv = axis.velocity_variance_m2_s2;
  const double p = axis.position_m - position_m;
  const double v = axis.velocity_m_s - velocity_m_s;
  const double determinant = pp * vv - pv * pv;
  return determinant > 0.0 ? (vv * p * p - 2.0 * pv * p * v + pp * v * v) / determinant : -1.0;
}

/// The ring buffer of a flight's log, and its reader.
class LogSink {
 public:
  explicit LogSink(bool keep) : storage_(keep ? kLogRingBytes : 1), ring_(storage_), log_(ring_) {}
  log::FlightLogWriter& log() { return log_; }
  void drain(std::vector<std::uint8_t>& into) {
    ring_.drain([&into](std::span<const std::byte> piece) {
      const auto* const first = reinterpret_cast<const std::uint8_t*>(piece.data());
      into.insert(into.end(), first, first + piece.size());
    });
  }

 private:
  std::vector<std::byte> storage_;
  log::Ring ring_;
  log::FlightLogWriter log_;
};

/// Everything that one flight needs, in the order of construction.
class Flight {
 public:
  explicit Flight(const FlightPlan& plan)
      : plan_(plan),
        vehicle_text_(companion::to_text(plan.vehicle.vehicle, plan.vehicle.sources)),
        tables_(
            gains::make_gain_tables(plan.vehicle.vehicle, companion::parse_vehicle(vehicle_text_, "vehicle").digest)),
        body_(plan.body != nullptr ? plan.body->flying_body(plan.plant, plan.seed, sim::WorldOptions{}.position_w_m)
                                   : nullptr),
        world_(plan.plant, world_of(plan, body_.get())),
        sink_(plan.keep_log) {
    if (body_) {
      body_->start_time();
    }
    start_.position_w_m = world_.aircraft().state().position_w_m;
    start_ = plan.start.value_or(start_);
    companion::parse_course(plan.course, start_, trajectory_);
    if (plan.keep_log) {
      begin_log();
    }
    controller_ =
        std::make_unique<Controller>(plan.vehicle.vehicle, tables_, config_of(plan, start_), world_.autopilot_uart(),
                                     world_.pose_uart(), trajectory_, plan.keep_log ? &sink_.log() : nullptr);
  }

  FlightResult run() {
    if (plan_.prepare) {
      plan_.prepare(world_);
    }
    if (!request_control()) {
      return finish();
    }
    result_.flew = true;
    const core::TimePoint begin = controller_->started();
    const est::EkfCounters before = controller_->observer_counters();
    const auto end = begin + core::Duration(static_cast<std::int64_t>(plan_.duration_s * 1e6));
    while (world_.now() < end) {
      const double t_s = core::seconds<double>(world_.now() - begin);
      if (plan_.disturb) {
        plan_.disturb(world_, t_s);
      }
      if (plan_.operate) {
        plan_.operate(*controller_, t_s);
      }
      note(t_s);
      tick();
    }
    const est::EkfCounters after = controller_->observer_counters();
    result_.nis_sum = static_cast<double>(after.nis_sum - before.nis_sum);
    result_.nis_count = after.poses_used - before.poses_used;
    controller_->release();
    for (const core::TimePoint last = world_.now() + kHandOver; world_.now() < last;) {
      tick();
    }
    result_.handed_over = !world_.autopilot().client_in_control() && !world_.autopilot().virtual_rc_on();
    return finish();
  }

 private:
  /// Writes the notes that a replay needs in addition to the bytes.
  void begin_log() {
    const gains::TableSet set{.tables = tables_, .x = {}, .y = {}};
    const std::vector<std::byte> tables = gains::to_file(set);
    const std::string channel = std::string(plan_.channel == link::Channel::kMovement ? "movement" : "virtual_rc") +
                                (plan_.paper_100_hz ? " paper_100_hz" : "");
    const std::string place = printed("%.17g %.17g %.17g %.17g", start_.position_w_m.x(), start_.position_w_m.y(),
                                      start_.position_w_m.z(), start_.yaw_rad);
    const std::string link = companion::link_note(config_of(plan_, start_));
    const std::string limits = plan_.flight_file ? to_text(*plan_.flight_file) : std::string();
    std::vector<log::Note> notes{{companion::kVehicleNote, vehicle_text_},
                                 {companion::kCourseNote, plan_.course},
                                 {companion::kStartNote, place},
                                 {companion::kChannelNote, channel},
                                 {companion::kLinkNote, link}};
    if (plan_.flight_file) {
      notes.push_back({companion::kFlightNote, limits});
    }
    M100_ASSERT(companion::add_table_notes({reinterpret_cast<const char*>(tables.data()), tables.size()}, notes));
    M100_ASSERT(sink_.log().begin(core::TimePoint{}, notes) == core::Status::kOk);
  }

  void tick() {
    world_.advance(core::kTickPeriod);
    static_cast<void>(controller_->tick(world_.now()));
    sink_.drain(result_.log);
    const core::Euler<double> attitude = world_.aircraft().attitude();
    const double tilt_deg = std::acos(std::cos(attitude.roll_rad) * std::cos(attitude.pitch_rad)) * core::kRadian_deg;
    result_.largest_tilt_deg = std::max(result_.largest_tilt_deg, tilt_deg);
  }

  /// Start-up over the wire, then the operator's order, until the failsafe is at nominal. @returns false: timed out.
  bool request_control() {
    bool ordered = false;
    for (const core::TimePoint last = world_.now() + kMaxStartUp; world_.now() < last;) {
      tick();
      const bool looked = !plan_.checks_poses_first || controller_->is_converged();
      const bool ready = looked && controller_->link().authority().stage == safety::AuthorityStage::kReady;
      if (ready && !ordered) {
        if (plan_.pilot_holds_position && !plan_.start) {
          start_.position_w_m = world_.aircraft().state().position_w_m;
          start_.yaw_rad = world_.aircraft().attitude().yaw_rad;
          companion::parse_course(plan_.course, start_, trajectory_);
        }
        controller_->engage();
        ordered = true;
      }
      if (controller_->grant().failsafe_state == safety::FailsafeState::kNominal) {
        return true;
      }
    }
    return false;
  }

  void note(double t_s) {
    const sim::VehicleState& truth = world_.aircraft().state();
    const core::Euler<double> attitude = world_.aircraft().attitude();
    const ref::Window<double> reference = trajectory_.window(world_.now(), core::Duration{0});
    const safety::SupervisedCommand<double>& grant = controller_->grant();
    TracePoint point;
    point.t_s = t_s;
    point.reference_m = {reference.x[0].position_m, reference.y[0].position_m, reference.height.position_m};
    point.position_m = {truth.position_w_m.x(), truth.position_w_m.y(), truth.position_w_m.z()};
    point.velocity_m_s = {truth.velocity_w_m_s.x(), truth.velocity_w_m_s.y(), truth.velocity_w_m_s.z()};
    point.reference_yaw_rad = reference.yaw_rad;
    point.yaw_rad = attitude.yaw_rad;
    point.roll_rad = attitude.roll_rad;
    point.pitch_rad = attitude.pitch_rad;
    point.applied_command = {grant.command.roll_rad, grant.command.pitch_rad, grant.command.climb_m_s,
                             grant.command.yaw_rate_rad_s};
    point.disturbance_m_s2 = {controller_->estimate().x.disturbance_m_s2, controller_->estimate().y.disturbance_m_s2};
    point.failsafe_state = static_cast<int>(grant.failsafe_state);
    const bool noticed = controller_->observed().limit_cycle.detected && result_.limit_cycle_detected_s < 0.0;
    result_.limit_cycle_detected_s = noticed ? t_s : result_.limit_cycle_detected_s;
    record_alarms();
    record_pose_age();
    const auto& estimate = controller_->estimate();
    const double x = normalised_square(estimate.x, point.position_m[0], point.velocity_m_s[0]);
    const double y = normalised_square(estimate.y, point.position_m[1], point.velocity_m_s[1]);
    point.nees = x >= 0.0 && y >= 0.0 ? x + y : -1.0;
    result_.trace.push_back(point);
  }

  void record_pose_age() {
    constexpr double kShare = 0.01;  // weight of a tick: a memory of one second
    const auto& estimate = controller_->estimate();
    if (estimate.refused_poses == 0 && estimate.pose_age < std::chrono::milliseconds(300)) {
      const core::Duration truly = world_.now() - world_.newest_pose_captured();
      result_.pose_age_error_s +=
          kShare * (core::seconds<double>(estimate.pose_age - truly) - result_.pose_age_error_s);
    }
  }

  void record_alarms() {
    const safety::Observation& seen = controller_->observed();
    result_.contradicted = result_.contradicted || controller_->contradiction().check != est::ConsistencyCheck::kNone;
    for (const bool left : seen.model.mismatch) {
      result_.model_mismatch = result_.model_mismatch || left;
    }
    result_.fence_stops = std::max(result_.fence_stops, seen.fence.stops);
    result_.refused_poses = std::max(result_.refused_poses, controller_->estimate().refused_poses);
  }

  /// The reason of the descent; for refused poses also what refused them: a campaign's list of failures has no log.
  std::string descent_text() const {
    const safety::FailsafeStep& step = controller_->supervisor().descent();
    const auto check = static_cast<est::ConsistencyCheck>(step.seen.consistency.contradicted_by);
    std::ostringstream text;
    text << safety::name(step.reason) << std::setprecision(3);
    if (step.reason == safety::FailsafeReason::kPoseRefused && check != est::ConsistencyCheck::kNone) {
      text << ", check " << est::name(check) << ": " << step.seen.consistency.contradicted_with << " "
           << est::unit_of(check) << " apart, allowed " << step.seen.consistency.contradicted_allowed;
    } else if (step.reason == safety::FailsafeReason::kPoseRefused) {
      text << ": " << step.seen.consistency.refused_by_m << " m from the prediction, allowed "
           << step.seen.consistency.refused_allowed_m;
    }
    return text.str();
  }

  FlightResult finish() {
    result_.start = start_;
    result_.simulated_s = core::seconds<double>(world_.now().time_since_epoch());
    result_.descent = descent_text();
    result_.authority = safety::name(controller_->link().authority().reason);
    result_.pose_timing = controller_->pose_timing();
    result_.touchdown_speed_m_s = world_.vehicle().touchdown_speed_m_s();
    result_.ticks = controller_->stats();
    result_.autopilot = world_.autopilot().record();
    result_.dropped_log_messages = plan_.keep_log ? sink_.log().dropped() : 0;
    return std::move(result_);
  }

  const FlightPlan& plan_;
  std::string vehicle_text_;
  mpc::GainTables<double> tables_;
  std::unique_ptr<sim::Body> body_;
  sim::World world_;
  ref::Trajectory<double> trajectory_;
  ref::Waypoint<double> start_;
  LogSink sink_;
  std::unique_ptr<Controller> controller_;
  FlightResult result_;
};

}  // namespace

FlightPlan in_paper_configuration(FlightPlan plan) {
  plan.vehicle = companion::as_file(model::paper_configuration(plan.vehicle.vehicle));
  plan.law = mpc::Law::kMpc;
  plan.paper_law = true;
  plan.responds_to_limit_cycles = false;
  plan.paper_100_hz = plan.paper_100_hz || plan.rate_hz == 0.0;
  return plan;
}

FlightResult fly(const FlightPlan& plan) {
  const auto before = std::chrono::steady_clock::now();
  FlightResult result = Flight(plan).run();
  result.computer_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  return result;
}

}  // namespace m100::lab::experiments
