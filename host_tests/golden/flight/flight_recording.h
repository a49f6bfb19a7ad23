// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/app/flight_controller.h"
#include "firmware/app/image/board_course.h"
#include "firmware/log/flight_log.h"
#include "firmware/mpc/generated/gain_table.h"
#include "hal/uart.h"
#include "host_tests/golden/number_hash.h"

// A recorded flight that a machine without files can replay: for each tick its head, then the bytes that arrived. It
// needs no heap and no exceptions, so the same code replays on a PC, under qemu-user and on the Cortex-M7 (promise R6).
namespace m100::golden {

/// Little-endian on every machine that replays.
struct RecordingHeader {
  std::uint32_t now_us;
  std::uint16_t autopilot_bytes;
  std::uint16_t pose_bytes;
  std::uint32_t engage;  ///< 1: the operator's order to fly comes before this tick; 2: the order to stop
};
static_assert(sizeof(RecordingHeader) == 12);

inline constexpr std::size_t kMaxRecordingBytes = 2048;  ///< of one direction in one tick
inline constexpr const char* kRecordingCourse = "trajectory";

struct RecordedTick {
  RecordingHeader head{};
  std::array<std::byte, kMaxRecordingBytes> autopilot{};
  std::array<std::byte, kMaxRecordingBytes> pose{};

  std::span<const std::byte> from_autopilot() const { return std::span(autopilot).first(head.autopilot_bytes); }
  std::span<const std::byte> from_pose() const { return std::span(pose).first(head.pose_bytes); }
};

/// Reads the next tick.
/// @param read fills a span as far as the recording goes and returns the number of bytes.
/// @returns false at the end of the recording, or where it is damaged.
template <typename Read>
bool read_tick(RecordedTick& tick, Read&& read) {
  std::array<std::byte, sizeof(RecordingHeader)> head{};
  if (read(std::span(head)) != head.size()) {
    return false;
  }
  tick.head = std::bit_cast<RecordingHeader>(head);
  const std::size_t autopilot = tick.head.autopilot_bytes;
  const std::size_t pose = tick.head.pose_bytes;
  return autopilot <= kMaxRecordingBytes && pose <= kMaxRecordingBytes &&
         read(std::span(tick.autopilot).first(autopilot)) == autopilot &&
         read(std::span(tick.pose).first(pose)) == pose;
}

/// A UART that gives the bytes of the recording for this tick and accepts what the program sends.
class ReplayedUart : public hal::Uart {
 public:
  void load(std::span<const std::byte> bytes) { waiting_ = bytes; }
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const std::size_t count = destination.size() < waiting_.size() ? destination.size() : waiting_.size();
    if (count > 0) {
      std::memcpy(destination.data(), waiting_.data(), count);
    }
    waiting_ = waiting_.subspan(count);
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return source.size(); }

 private:
  std::span<const std::byte> waiting_;
};

/// Runs the flight program on a recording. Its log holds the bytes in, the bytes out and the state record of each tick,
/// so the hash of the log is the hash of the flight. T, S: scalars of FlightController.
template <typename T, typename S>
class ReplayedFlight {
 public:
  /// @param logged false: without a log, as in the flight image, to measure the tick alone; the hash is then
  ///   meaningless.
  /// @param as_image solves its quadratic programs in the same ticks as the image.
  explicit ReplayedFlight(bool logged = true, bool as_image = false)
      : ReplayedFlight([](ref::Trajectory<T>& course) { return app::append_board_course(kRecordingCourse, course); },
                       config(as_image), logged) {}
  /// @param lay lays another course and returns a status.
  template <typename Lay>
  ReplayedFlight(Lay&& lay, const app::FlightConfig& config, bool logged = true)
      : course_status_(lay(course_)),
        controller_(mpc::generated::kVehicle, tables_, config, autopilot_, pose_, course_, logged ? &log_ : nullptr) {}

  void load(const RecordedTick& tick) {
    autopilot_.load(tick.from_autopilot());
    pose_.load(tick.from_pose());
    now_ = core::TimePoint(core::Duration(tick.head.now_us));
    if (tick.head.engage == 1) {
      controller_.engage();
    } else if (tick.head.engage == 2) {
      controller_.release();
    }
    if (again_and_again_ && course_.finished(now_)) {
      course_.start(now_);
    }
  }
  /// Replaces the recorded course by moves between +3 m and -3 m, one every third of a second, so that limits always
  /// bind.
  void fly_far_and_often() {
    using namespace std::chrono_literals;
    again_and_again_ = true;
    const auto place = [](T x_m) { return ref::Waypoint<T>{.position_w_m = {x_m, -x_m, T(1.5)}, .yaw_rad = T(0)}; };
    course_.hold(place(T(0)));
    for (std::size_t i = 0; i + 1 < ref::Trajectory<T>::kMaxPieces; ++i) {
      static_cast<void>(course_.append_quintic(place(i % 2 == 0 ? T(3) : T(-3)), 333ms));
    }
  }
  void tick() { static_cast<void>(controller_.tick(now_)); }
  void drain() {
    ring_.drain([this](std::span<const std::byte> piece) { hash_.update(piece); });
  }
  /// @returns the hash; empty if the log was too small for a tick or the course could not be laid, so that an
  ///   incomplete flight has no hash.
  HashText finish() {
    drain();
    return ring_.dropped() == 0 && course_status_ == core::Status::kOk ? core::hex(hash_.finish()) : HashText{};
  }
  /// @returns the hash of the flight so far; the flight goes on.
  HashText so_far() const {
    core::Sha256 hash = hash_;
    return ring_.dropped() == 0 && course_status_ == core::Status::kOk ? core::hex(hash.finish()) : HashText{};
  }
  const app::FlightController<T, S>& controller() const { return controller_; }

 private:
  static app::FlightConfig config(bool as_image) {
    app::FlightConfig config = app::kDefaultFlight;
    config.link.app_id = 1;
    config.solves_when_due = as_image;
    return config;
  }

  std::array<std::byte, 16384> storage_{};
  log::Ring ring_{storage_};
  log::FlightLogWriter log_{ring_};
  core::Sha256 hash_;
  ReplayedUart autopilot_;
  ReplayedUart pose_;
  ref::Trajectory<T> course_;
  core::Status course_status_;
  mpc::GainTables<T> tables_{mpc::generated::kX<T>, mpc::generated::kY<T>};
  app::FlightController<T, S> controller_;
  core::TimePoint now_{};
  bool again_and_again_ = false;
};

}  // namespace m100::golden
