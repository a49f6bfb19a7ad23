// SPDX-License-Identifier: BSD-3-Clause
// How each channel is falsified, and the effect on a flight.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/tasks.h"
#include "host_tests/scenario/sensor_faults/fault_search.h"

namespace m100::scenario {
namespace {

using lab::experiments::FlightPlan;
using lab::experiments::FlightResult;
using protocol::Telemetry;
using protocol::TelemetryItem;

constexpr auto kWave = Channel::Kind::kWave;
// Sizes in the channel's unit: from hidden in the noise to obvious.
constexpr std::array kChannels{
    Channel{"pose.position", "m", kWave, {0.005, 3.0, 3}}, Channel{"pose.heading", "rad", kWave, {0.01, 3.0, 1}},
    Channel{"attitude", "rad", kWave, {0.002, 0.5, 3}},    Channel{"rates", "rad/s", kWave, {0.01, 3.0, 3}},
    Channel{"force", "g", kWave, {0.005, 1.0, 3}},         Channel{"velocity", "m/s", kWave, {0.05, 5.0, 3}},
    Channel{"height", "m", kWave, {0.05, 5.0, 1}},         Channel{"answers", "", Channel::Kind::kAutopilot, {}},
    Channel{"operator", "", Channel::Kind::kOperator, {}},
};

Value vector_of(const std::array<float, 3>& values) { return {values[0], values[1], values[2]}; }
std::array<float, 3> floats_of(const Value& value) {
  return {static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2])};
}

/// A channel of telemetry with one or three numbers: how it is read and written.
struct Numbers {
  std::string_view channel;
  TelemetryItem item;
  bool anchored;  ///< gain and sign act on the difference from the beginning
  Value (*read)(const Telemetry&);
  void (*write)(Telemetry&, const Value&);
};
constexpr std::array kNumbers{
    Numbers{"attitude", TelemetryItem::kAttitude, false,
            [](const Telemetry& t) {
              const core::Euler<double> e =
                  core::euler_of(core::Quaternion<double>{t.attitude[0], t.attitude[1], t.attitude[2], t.attitude[3]});
              return Value(e.roll_rad, e.pitch_rad, e.yaw_rad);
            },
            [](Telemetry& t, const Value& v) {
              const auto q = core::quaternion_of(core::Euler<double>{v[0], v[1], v[2]});
              t.attitude = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                            static_cast<float>(q.z)};
            }},
    Numbers{"rates", TelemetryItem::kAngularVelocity, false,
            [](const Telemetry& t) { return vector_of(t.angular_velocity_frd_rad_s); },
            [](Telemetry& t, const Value& v) { t.angular_velocity_frd_rad_s = floats_of(v); }},
    Numbers{"force", TelemetryItem::kAcceleration, false, [](const Telemetry& t) { return vector_of(t.acceleration); },
            [](Telemetry& t, const Value& v) { t.acceleration = floats_of(v); }},
    Numbers{"velocity", TelemetryItem::kVelocity, false,
            [](const Telemetry& t) { return vector_of(t.velocity_ned_m_s); },
            [](Telemetry& t, const Value& v) { t.velocity_ned_m_s = floats_of(v); }},
    Numbers{"height", TelemetryItem::kPosition, true,
            [](const Telemetry& t) { return Value(static_cast<double>(t.position.height_m), 0.0, 0.0); },
            [](Telemetry& t, const Value& v) { t.position.height_m = static_cast<float>(v[0]); }},
};

void inject_into_telemetry(const Channel& channel, const Waveform& wave, std::uint64_t seed, core::TimePoint begin,
                           sim::World& world) {
  const auto* const numbers =
      std::find_if(kNumbers.begin(), kNumbers.end(), [&](const Numbers& row) { return row.channel == channel.name; });
  const auto injector = std::make_shared<WaveformInjector>(wave, seed);
  world.autopilot().set_telemetry_fault([numbers, injector, begin, &world](Telemetry& telemetry) {
    if (!telemetry.has(numbers->item)) {
      return;
    }
    const double t_s = core::seconds<double>(world.now() - begin);
    const std::optional<Value> faulted = injector->apply(t_s, numbers->read(telemetry), numbers->anchored);
    if (faulted) {
      numbers->write(telemetry, *faulted);
    } else {
      telemetry.items = static_cast<std::uint16_t>(telemetry.items & ~static_cast<unsigned>(numbers->item));
    }
  });
}

bool drops(const Waveform& wave, double t_s) {
  return std::any_of(wave.begin(), wave.end(), [t_s](const Piece& piece) {
    return piece.shape == WaveformShape::kDropout && t_s >= piece.from_s && t_s <= piece.from_s + piece.for_s;
  });
}

std::function<void(sim::PoseSample&)> pose_fault(const Channel& channel, const Waveform& wave, std::uint64_t seed,
                                                 core::TimePoint begin) {
  const auto injector = std::make_shared<WaveformInjector>(wave, seed);
  const bool heading = channel.name == "pose.heading";
  return [injector, begin, heading](sim::PoseSample& sample) {
    const double t_s = core::seconds<double>(sample.captured - begin);
    const Value truth = heading ? Value(sample.yaw_rad, 0.0, 0.0) : Value(sample.position_w_m);
    const Value faulted = injector->apply(t_s, truth, true).value_or(truth);
    if (heading) {
      sample.yaw_rad = faulted[0];
    } else {
      sample.position_w_m = faulted;
    }
  };
}

/// Makes telemetry report a wrong controlling device or mode, as the happenings say for this time.
void falsify_status(const CommandFaults& command_faults, double t_s, Telemetry& telemetry) {
  for (const CommandFault& one : command_faults) {
    if (t_s < one.at_s || t_s > one.at_s + one.value) {
      continue;
    }
    const unsigned others = telemetry.control.bits & ~7U;
    if (one.kind == CommandFaultKind::kReportsOurs || one.kind == CommandFaultKind::kReportsPilot) {
      const auto device = one.kind == CommandFaultKind::kReportsOurs ? protocol::ControlDevice::kOnboardComputer
                                                                     : protocol::ControlDevice::kRemoteController;
      telemetry.control.bits = static_cast<std::uint8_t>(others | static_cast<unsigned>(device));
    } else if (one.kind == CommandFaultKind::kReportsMode) {
      telemetry.rc.mode = protocol::kRcModeA;
    }
  }
}

void happen(const CommandFault& one, sim::N1Autopilot& autopilot) {
  if (one.kind == CommandFaultKind::kLoseAcks) {
    autopilot.happen(sim::N1EventKind::kLoseAcks, one.value);
  } else if (one.kind == CommandFaultKind::kDoubleAcks) {
    autopilot.happen(sim::N1EventKind::kDoubleAcks, one.value);
  } else if (one.kind == CommandFaultKind::kDelayAcks) {
    autopilot.happen(sim::N1EventKind::kDelayAcks, one.value);
  }
}

/// Gives each happening once, at its time.
class Script {
 public:
  explicit Script(CommandFaults command_faults) : happenings_(std::move(command_faults)) {
    std::sort(happenings_.begin(), happenings_.end(), [](const auto& a, const auto& b) { return a.at_s < b.at_s; });
  }
  template <typename Do>
  void play(double t_s, const Do& act) {
    for (; next_ < happenings_.size() && happenings_[next_].at_s <= t_s; ++next_) {
      act(happenings_[next_]);
    }
  }

 private:
  CommandFaults happenings_;
  std::size_t next_ = 0;
};

void plant_wave(const Channel& channel, const Fault& fault, std::uint64_t seed, FlightPlan& plan) {
  plan.disturb = [&channel, &fault, seed, falsify = std::function<void(sim::PoseSample&)>()](sim::World& world,
                                                                                             double t_s) mutable {
    const bool of_pose = channel.name.substr(0, 5) == "pose.";
    if (!falsify) {
      const core::TimePoint begin = world.now() - core::Duration(std::llround(t_s * 1e6));
      falsify = pose_fault(channel, fault.wave, seed, begin);
      if (!of_pose) {
        inject_into_telemetry(channel, fault.wave, seed, begin, world);
      }
    }
    if (of_pose) {
      world.pose_source().set_faults({.silent = drops(fault.wave, t_s), .fault = falsify});
    }
  };
}

void plant_words(const Channel& channel, const Fault& fault, FlightPlan& plan) {
  const auto script = std::make_shared<Script>(fault.command_faults);
  if (channel.kind == Channel::Kind::kOperator) {
    plan.operate = [script](app::FlightController<double>& controller, double t_s) {
      script->play(t_s, [&](const CommandFault& one) {
        one.kind == CommandFaultKind::kEngage ? controller.engage() : controller.release();
      });
    };
    return;
  }
  plan.disturb = [script, &fault](sim::World& world, double t_s) {
    if (t_s == 0.0) {
      const core::TimePoint begin = world.now();
      world.autopilot().set_telemetry_fault([begin, &world, &fault](Telemetry& telemetry) {
        falsify_status(fault.command_faults, core::seconds<double>(world.now() - begin), telemetry);
      });
    }
    script->play(t_s, [&](const CommandFault& one) { happen(one, world.autopilot()); });
  };
}

FlightPlan plan_of(const std::string& task_name, std::uint64_t seed) {
  const lab::campaign::Task task = lab::campaign::tasks_of(task_name).front();
  FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = task.course;
  plan.duration_s = kObserved_s;
  plan.seed = seed;
  plan.pilot_holds_position = true;
  return plan;
}

/// The flight without a fault; each is flown once for all faults.
const FlightResult& flown_without_fault(const std::string& task, std::uint64_t seed) {
  static std::map<std::pair<std::string, std::uint64_t>, FlightResult> kept;
  const auto key = std::make_pair(task, seed);
  const auto found = kept.find(key);
  return found != kept.end() ? found->second
                             : kept.emplace(key, lab::experiments::fly(plan_of(task, seed))).first->second;
}

double beginning_of(const Fault& fault) {
  double begin_s = kObserved_s;
  for (const Piece& piece : fault.wave) {
    begin_s = std::min(begin_s, piece.from_s);
  }
  for (const CommandFault& one : fault.command_faults) {
    begin_s = std::min(begin_s, one.at_s);
  }
  return begin_s;
}

}  // namespace

std::span<const Channel> channels() { return kChannels; }

const Channel& channel_of(std::string_view name) {
  const auto* const found =
      std::find_if(kChannels.begin(), kChannels.end(), [&](const Channel& channel) { return channel.name == name; });
  if (found == kChannels.end()) {
    throw std::invalid_argument("unknown channel " + std::string(name));
  }
  return *found;
}

FaultEffect effect_of(const Channel& channel, const Fault& fault, std::uint64_t seed) {
  const FlightResult& fault_free = flown_without_fault(fault.task, seed);
  FlightPlan plan = plan_of(fault.task, seed);
  channel.kind == Channel::Kind::kWave ? plant_wave(channel, fault, seed, plan) : plant_words(channel, fault, plan);
  const FlightResult struck = lab::experiments::fly(plan);
  FaultEffect effect;
  bool commanded = true;
  auto noticed_m = struck.trace.front().position_m;
  for (std::size_t i = 0; i < std::min(fault_free.trace.size(), struck.trace.size()); ++i) {
    const lab::experiments::TracePoint& point = struck.trace[i];
    const auto& a = fault_free.trace[i].position_m;
    const auto& b = point.position_m;
    const double away_m = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    const bool silent = point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent);
    if (effect.after_s == FaultEffect::kNever) {
      effect.away_m = std::max(effect.away_m, away_m);
      effect.after_s = point.failsafe_state != static_cast<int>(safety::FailsafeState::kNominal)
                           ? point.t_s - beginning_of(fault)
                           : FaultEffect::kNever;
    }
    noticed_m = effect.after_s == FaultEffect::kNever ? b : noticed_m;
    effect.went_on_m =
        silent ? effect.went_on_m
               : std::max(effect.went_on_m, std::hypot(b[0] - noticed_m[0], b[1] - noticed_m[1], b[2] - noticed_m[2]));
    effect.farthest_m = silent ? effect.farthest_m : std::max(effect.farthest_m, away_m);
    if (silent && commanded) {
      effect.speed_m_s = std::max(effect.speed_m_s, std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]));
    }
    commanded = !silent;
  }
  return effect;
}

}  // namespace m100::scenario
