// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/record/recorder.h"

#include <algorithm>

#include "firmware/companion/record/records.h"
#include "firmware/core/frames.h"
#include "firmware/link/telemetry/telemetry_check.h"
#include "firmware/link/telemetry/telemetry_clock.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {
namespace {

using protocol::TelemetryItem;

constexpr core::Duration kAdapterDelay = std::chrono::milliseconds(20);  // an FTDI's timer is 16 ms
// The rule of m100-lab that distinguishes a gap from a slow stream.
constexpr double kGap_s = 0.05;
constexpr double kGapIntervals = 3.5;
constexpr std::uint64_t kFewestIntervals = 10;
constexpr double kCountsPerFull = 660.0 / 10000.0;  // Virtual RC counts per unit of the RC item

constexpr std::array<std::string_view, Recorder::kStreams + 1> kFormats{
    recording::Rc::kFormat,     recording::Attitude::kFormat, recording::kRatesFormat,
    recording::kVelocityFormat, recording::kForceFormat,      recording::Position::kFormat,
    recording::Status::kFormat, recording::Pose::kFormat,     log::kBytesFormat};
constexpr std::uint16_t kBytesId = Recorder::kStreams;

std::array<float, 3> turned(const std::array<float, 3>& frd) { return {frd[0], -frd[1], -frd[2]}; }

std::uint64_t microseconds(core::TimePoint at) { return static_cast<std::uint64_t>(at.time_since_epoch().count()); }

}  // namespace

std::string_view Recorder::name(Stream stream) { return kFormats[stream].substr(0, kFormats[stream].find(':')); }

double Recorder::StreamStatistics::rate_hz() const {
  const double span_s = core::seconds<double>(last - first);
  return span_s > 0.0 ? static_cast<double>(samples - 1) / span_s : 0.0;
}

void Recorder::StreamStatistics::add(core::TimePoint at) {
  if (samples == 0) {
    first = at;
  } else {
    note_gap(at - last);
  }
  last = at;
  ++samples;
}

void Recorder::StreamStatistics::end(core::TimePoint at) {
  if (samples > 0 && at > last) {
    note_gap(at - last);
  }
}

void Recorder::StreamStatistics::note_gap(core::Duration gap) {
  longest_gap = std::max(longest_gap, gap);
  const bool knows_its_interval = samples >= kFewestIntervals;
  const double gap_s = core::seconds<double>(gap);
  gaps += knows_its_interval && gap_s > kGap_s && gap_s * rate_hz() > kGapIntervals ? 1U : 0U;
}

void Recorder::end(core::TimePoint now) {
  for (StreamStatistics& statistics : statistics_) {
    statistics.end(now);
  }
}

Recorder::Recorder(log::UlogWriter& log, std::uint32_t baud, const protocol::Cipher* cipher)
    : log_(log), cipher_(cipher), candidates_(baud) {}

core::Status Recorder::begin(core::TimePoint now, std::span<const log::Note> notes) {
  return log_.begin(now, kFormats, notes);
}

void Recorder::take(std::span<const std::byte> bytes, core::TimePoint now) {
  log::append_bytes(log_, kBytesId, log::Stream::kAutopilotIn, now, bytes);
  parser_.consume(bytes, [&](const protocol::FrameView& frame) { handle(frame, now); });
}

void Recorder::reject_false_frames(core::TimePoint now) {
  while (candidates_.is_false(parser_, now, kAdapterDelay)) {
    parser_.abandon_candidate();
    for (auto frame = parser_.poll(); frame; frame = parser_.poll()) {
      handle(*frame, now);
    }
  }
}

void Recorder::handle(const protocol::FrameView& frame, core::TimePoint now) {
  const core::Expected<protocol::Message> message = protocol::open(frame, cipher_, scratch_);
  if (!message) {
    ++undecipherable_;
    return;
  }
  if (message->header.is_ack || !message->has_id || message->id != protocol::ids::kTelemetry) {
    return;
  }
  const protocol::Telemetry former = telemetry_;
  if (protocol::decode_telemetry(message->value, telemetry_) != core::Status::kOk) {
    ++bad_packages_;
    return;
  }
  (void)link::reject_non_finite(telemetry_, former);
  ++packages_;
  write_package(now);
}

void Recorder::write_package(core::TimePoint arrived) {
  const core::TimePoint made =
      telemetry_.has(TelemetryItem::kTime)
          ? clock_.to_our_clock(static_cast<std::int64_t>(telemetry_.time.ticks) * link::TelemetryClock::kTick, arrived)
          : arrived;
  const std::uint64_t stamp_us = microseconds(made);
  write_sticks(stamp_us);
  write_motion(stamp_us);
  write_rest(stamp_us);
}

template <typename Record>
void Recorder::write(Stream stream, const Record& record) {
  statistics_[stream].add(core::TimePoint{core::Duration{static_cast<std::int64_t>(record.timestamp)}});
  log_.append(static_cast<std::uint16_t>(stream), std::as_bytes(std::span(&record, 1)));
}

void Recorder::write_sticks(std::uint64_t stamp_us) {
  if (!telemetry_.has(TelemetryItem::kRc)) {
    return;
  }
  const protocol::Telemetry::Rc& rc = telemetry_.rc;
  const std::array<std::int16_t, 4> moved{rc.roll, rc.pitch, rc.throttle, rc.yaw};
  for (std::size_t stick = 0; stick < moved.size(); ++stick) {
    const double counts = kCountsPerFull * moved[stick];
    sticks_[stick] = {std::min(sticks_[stick].min_counts, counts), std::max(sticks_[stick].max_counts, counts)};
  }
  write(kRc, recording::Rc{.timestamp = stamp_us,
                           .roll = rc.roll,
                           .pitch = rc.pitch,
                           .throttle = rc.throttle,
                           .yaw = rc.yaw,
                           .mode = rc.mode,
                           .gear = rc.gear,
                           .package = packages_});
}

void Recorder::write_motion(std::uint64_t stamp_us) {
  const auto vector = [&](const std::array<float, 3>& frd) {
    return recording::Vector{.timestamp = stamp_us, .xyz = turned(frd), .package = packages_};
  };
  if (telemetry_.has(TelemetryItem::kAttitude)) {
    const std::array<float, 4>& q = telemetry_.attitude;
    const core::Euler<float> euler = core::euler_of(core::flip_yz(core::Quaternion<float>{q[0], q[1], q[2], q[3]}));
    write(kAttitude, recording::Attitude{.timestamp = stamp_us,
                                         .roll = euler.roll_rad,
                                         .pitch = euler.pitch_rad,
                                         .yaw = euler.yaw_rad,
                                         .package = packages_});
  }
  if (telemetry_.has(TelemetryItem::kAngularVelocity)) {
    write(kRates, vector(telemetry_.angular_velocity_frd_rad_s));
  }
  if (telemetry_.has(TelemetryItem::kVelocity)) {
    write(kVelocity, vector(telemetry_.velocity_ned_m_s));
  }
  if (telemetry_.has(TelemetryItem::kAcceleration)) {
    write(kForce, vector(telemetry_.acceleration));
  }
}

void Recorder::write_rest(std::uint64_t stamp_us) {
  if (telemetry_.has(TelemetryItem::kPosition)) {
    const protocol::Telemetry::Position& p = telemetry_.position;
    write(kPosition, recording::Position{.timestamp = stamp_us,
                                         .latitude = p.latitude_rad,
                                         .longitude = p.longitude_rad,
                                         .altitude = p.altitude_m,
                                         .height = p.height_m,
                                         .gps_health = p.gps_health,
                                         .package = packages_});
  }
  if (telemetry_.has(TelemetryItem::kFlightStatus) || telemetry_.has(TelemetryItem::kBattery) ||
      telemetry_.has(TelemetryItem::kControl)) {
    const protocol::Telemetry::Control& control = telemetry_.control;
    computer_packages_ +=
        control.virtual_rc_on() || control.device() == protocol::ControlDevice::kOnboardComputer ? 1U : 0U;
    write(kStatus, recording::Status{.timestamp = stamp_us,
                                     .flight_status = static_cast<std::uint8_t>(telemetry_.flight_status),
                                     .battery_percent = telemetry_.battery_percent,
                                     .control_mode = control.mode,
                                     .control_bits = control.bits,
                                     .package = packages_});
  }
}

void Recorder::take(const core::Pose<double>& pose) {
  const core::Vector<double, 3>& p = pose.position_w_m;
  const core::TimePoint captured =
      pose_clock_.to_our_clock(core::Duration(pose.captured.time_since_epoch().count()), pose.arrived);
  write(kPose, recording::Pose{.timestamp = microseconds(captured),
                               .xyz = {p.x(), p.y(), p.z()},
                               .yaw = pose.yaw_rad,
                               .arrived = microseconds(pose.arrived),
                               .sequence = pose.sequence});
}

}  // namespace m100::companion
