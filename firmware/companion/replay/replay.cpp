// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/replay/replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/excitation_file.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/flight_limits.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/ground_station/guided_mode.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/mpc/table_file.h"
#include "hal/uart.h"

namespace m100::companion {
namespace {

/// Gives a tick the bytes that it read in flight, and keeps what it writes.
class RecordedUart final : public hal::Uart {
 public:
  /// @param mute refuses every write, as the port of a dry run does.
  explicit RecordedUart(bool mute) : mute_(mute) {}
  void next(const std::vector<std::byte>& input) {
    input_ = &input;
    at_ = 0;
    written_.clear();
  }
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const std::size_t count = input_ == nullptr ? 0 : std::min(destination.size(), input_->size() - at_);
    for (std::size_t i = 0; i < count; ++i) {
      destination[i] = (*input_)[at_ + i];
    }
    at_ += count;
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override {
    if (mute_) {
      return core::Status::kUnavailable;
    }
    written_.insert(written_.end(), source.begin(), source.end());
    return source.size();
  }
  const std::vector<std::byte>& written() const { return written_; }

 private:
  bool mute_;
  const std::vector<std::byte>* input_ = nullptr;
  std::size_t at_ = 0;
  std::vector<std::byte> written_;
};

template <typename T>
ref::Waypoint<T> start_of(const RecordedFlight& flight) {
  std::istringstream words(note_of(flight, kStartNote));
  std::array<double, 4> n{};
  for (double& value : n) {
    words >> value;
  }
  if (!words) {
    throw FlightLogError(std::string("'") + kStartNote + "' needs four numbers");
  }
  ref::Waypoint<T> start;
  start.position_w_m = core::Vector<double, 3>(n[0], n[1], n[2]).cast<T>();
  start.yaw_rad = static_cast<T>(n[3]);
  return start;
}

app::FlightConfig config_of(const RecordedFlight& flight, const protocol::Cipher* cipher) {
  app::FlightConfig config = app::kDefaultFlight;
  const std::string& channel = note_of(flight, kChannelNote);
  config.link.app_id = 1;
  bool encrypted = false;
  if (flight.notes.contains(kLinkNote)) {
    encrypted = read_link_note(note_of(flight, kLinkNote), config);
  }
  if (flight.notes.contains(kFlightNote)) {
    const FlightFile file = parse_flight(note_of(flight, kFlightNote), kFlightNote);
    config.limits = limits_of(file);
    config.fence = fence_of(file, start_of<double>(flight));
    config.pose_offset_b_m = file.pose_offset_m;
  }
  if (encrypted && cipher == nullptr) {
    throw FlightLogError("the flight's commands were encrypted: its key is needed (--key-file)");
  }
  config.link.cipher = encrypted ? cipher : nullptr;
  config.link.encrypt_commands = encrypted;
  config.link.channel.channel = channel.starts_with("movement") ? link::Channel::kMovement : link::Channel::kVirtualRc;
  config.link.channel.paper_100_hz = channel.find("paper_100_hz") != std::string::npos;
  if (!link::command_period(config.link.channel)) {
    throw FlightLogError("the log's command rate is outside its channel's window");
  }
  return config;
}

/// @returns nullopt: the flight took no goals.
std::optional<GoalSettings> goal_settings_of(const RecordedFlight& flight) {
  if (!flight.notes.contains(kGoalsNote)) {
    return {};
  }
  const std::optional<GoalSettings> settings = goals_of_note(note_of(flight, kGoalsNote));
  if (!settings) {
    throw FlightLogError(std::string("'") + kGoalsNote + "' is of another version");
  }
  return settings;
}

/// Without the note, as in an older log, the flight ignored the battery.
template <typename T>
ReturnToStart<T> home_of(const RecordedFlight& flight, const app::FlightConfig& config, ref::Trajectory<T>& course) {
  const std::optional<ReturnSettings> settings =
      flight.notes.contains(kHomeNote) ? home_of_note(note_of(flight, kHomeNote)) : ReturnSettings{};
  if (!settings) {
    throw FlightLogError(std::string("'") + kHomeNote + "' is of another version");
  }
  return ReturnToStart<T>(course, config.fence, start_of<T>(flight), *settings);
}

/// Applies goals and a low battery to the course, as the flight did after the same tick.
template <typename T, typename S>
void lead(std::optional<GoalFollower<T>>& goals, GroundStationTap& line, ReturnToStart<T>& home,
          const app::FlightController<T, S>& controller, core::TimePoint now) {
  if (goals && home.state() == ReturnToStart<T>::State::kInactive) {
    (void)update_guided_mode(*goals, line, controller, now);
  } else if (goals) {
    (void)reject_goals(line);
  }
  home.update(controller, now);
}

/// Ignores a time request to the pose port that the log lacks: the flight's port may have refused to write it.
bool same_bytes(const RecordedUart& autopilot, const RecordedUart& pose, const RecordedFlight::Tick& then) {
  return autopilot.written() == then.autopilot_out && (then.pose_out.empty() || pose.written() == then.pose_out);
}

/// Compares bits: a NaN equals itself, and minus zero differs from zero.
template <typename Record>
bool is_same(const Record& now, const Record& then) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): records have no padding (records.h)
  return std::memcmp(&now, &then, sizeof now) == 0;
}

void compare(const log::TickRecord& now, const RecordedFlight::Tick& then, bool same, std::size_t tick,
             ReplayResult& result) {
  if (!same) {
    result.first_difference = result.different_ticks++ == 0 ? tick : result.first_difference;
    result.differences.push_back(tick);
  }
  for (std::size_t i = 0; i < now.position.size(); ++i) {
    result.largest_difference_m =
        std::max(result.largest_difference_m, std::abs(now.position[i] - then.record.position[i]));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    result.largest_command_difference_rad =
        std::max(result.largest_command_difference_rad, std::abs(now.granted[i] - then.record.granted[i]));
  }
}

/// Repeats the operator's order for a task of the autopilot.
template <typename Controller>
void order_task(Controller& controller, std::uint32_t orders) {
  const bool takes_off = (orders & log::kOrderTakesOff) != 0;
  const protocol::Task task = takes_off ? protocol::Task::kTakeOff : protocol::Task::kLand;
  if (takes_off || (orders & log::kOrderLands) != 0) {
    controller.task_flies(!takes_off);
  }
  if ((orders & log::kOrderTask) != 0) {
    (void)controller.begin_task(task);
  }
}

core::TimePoint time_of(const RecordedFlight::Tick& tick) {
  return core::TimePoint(core::Duration(tick.record.timestamp));
}

bool earlier(const RecordedFlight::Tick& a, const RecordedFlight::Tick& b) { return time_of(a) < time_of(b); }

void expect_replayable(const RecordedFlight& flight) {
  if (flight.flew_mission) {
    throw FlightLogError("the flight flew a MAVLink mission, which this version does not fly: it cannot be replayed");
  }
  if (!std::is_sorted(flight.ticks.begin(), flight.ticks.end(), earlier)) {
    throw FlightLogError("the times of the log's ticks go backwards: it is damaged");
  }
}

template <typename T, typename S>
ReplayResult run(const RecordedFlight& flight, const protocol::Cipher* cipher,
                 const std::function<void(const app::FlightController<T, S>&)>& observe = {}) {
  expect_replayable(flight);
  const VehicleFile vehicle = parse_vehicle(note_of(flight, kVehicleNote), kVehicleNote);
  const auto tables = std::make_unique<mpc::TableStorage<T>>();
  const std::string table_bytes = tables_of(flight);
  if (tables->load(std::as_bytes(std::span(table_bytes.data(), table_bytes.size())), vehicle.digest) !=
      core::Status::kOk) {
    throw FlightLogError("the log's gain tables are damaged or belong to another vehicle");
  }
  ref::Trajectory<T> course;
  parse_course(note_of(flight, kCourseNote), start_of<T>(flight), course);
  std::optional<ExcitationFile> excitation;
  app::FlightConfig config = config_of(flight, cipher);
  if (flight.notes.contains(kExcitationNote)) {
    excitation = excitation_of_note(note_of(flight, kExcitationNote));
    config.excitation = excitation->plan();
  }
  RecordedUart autopilot(flight.notes.contains(kDryRunNote));
  RecordedUart pose(false);
  const std::optional<GoalSettings> goal_settings = goal_settings_of(flight);
  GroundStationTap overheard(pose, goal_settings ? goal_settings->only : std::nullopt);
  auto goals = goal_settings ? std::optional<GoalFollower<T>>(std::in_place, course, config.fence, *goal_settings)
                             : std::nullopt;
  ReturnToStart<T> home = home_of(flight, config, course);
  const auto controller = std::make_unique<app::FlightController<T, S>>(vehicle.vehicle, tables->tables(), config,
                                                                        autopilot, overheard, course, nullptr);
  core::Sha256 hash;
  ReplayResult result;
  for (const RecordedFlight::Tick& tick : flight.ticks) {
    if ((tick.record.orders & log::kOrderEngage) != 0) {
      controller->engage();
    }
    if ((tick.record.orders & log::kOrderRelease) != 0) {
      controller->release();
    }
    order_task(*controller, tick.record.orders);
    autopilot.next(tick.autopilot_in);
    pose.next(tick.pose_in);
    static_cast<void>(controller->tick(time_of(tick)));
    const app::TickRecord<T>& flown = controller->record();
    const log::TickRecord now = app::logged(flown, 0);
    const bool same = is_same(now, tick.record) && flown.excitation.has_value() == tick.excitation.has_value() &&
                      (!flown.excitation || is_same(*flown.excitation, *tick.excitation)) &&
                      same_bytes(autopilot, pose, tick);
    lead(goals, overheard, home, *controller, time_of(tick));
    if (observe) {
      observe(*controller);
    }
    hash.update(autopilot.written());
    hash.update(std::as_bytes(std::span(&now, 1)));
    compare(now, tick, same, result.ticks, result);
    ++result.ticks;
    result.messages_missing = tick.record.dropped_messages;
  }
  result.digest = hash.finish();
  return result;
}

}  // namespace

ReplayResult replay(const RecordedFlight& flight, Scalar scalar, const protocol::Cipher* cipher) {
  switch (scalar) {
    case Scalar::kFloat:
      return run<float, float>(flight, cipher);
    case Scalar::kFixed:
      return run<float, core::Fixed>(flight, cipher);
    case Scalar::kDouble:
      break;
  }
  return run<double, double>(flight, cipher);
}

ReplayResult replay(const RecordedFlight& flight, const protocol::Cipher* cipher,
                    const std::function<void(const app::FlightController<double, double>&)>& observe) {
  return run<double, double>(flight, cipher, observe);
}

}  // namespace m100::companion
