// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/autopilot/event_file.h"

#include <chrono>

#include "host_tests/lab/input_error.h"

namespace m100::lab::autopilot {
namespace {

constexpr core::Duration kTruthPeriod = std::chrono::milliseconds(100);

double since_start_s(core::TimePoint at) { return core::seconds<double>(at.time_since_epoch()); }

/// A smallest spacing of requests in seconds; -1: there were fewer than two requests.
double spacing_s(core::Duration spacing) {
  return spacing == core::Duration::max() ? -1.0 : core::seconds<double>(spacing);
}

}  // namespace

EventFile::EventFile(const std::string& path, WriteMode writes) : path_(path), file_(path) {
  expect_written();
  if (writes == WriteMode::kInAThread) {
    writer_ = std::jthread([this](const std::stop_token& stop) { write_waiting(stop); });
  }
}

void EventFile::expect_written() const {
  if (!file_) {
    throw InputError(path_, 0, "--events", "cannot be written");
  }
}

void EventFile::write_line(const Json& line) {
  const std::string text = line.dump() + '\n';
  if (!writer_.joinable()) {
    file_ << text << std::flush;
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    waiting_ += text;
  }
  lines_came_.notify_one();
}

/// The thread: writes the waiting lines until it is asked to stop and none waits any more.
void EventFile::write_waiting(const std::stop_token& stop) {
  for (bool more = true; more;) {
    std::string text;
    {
      std::unique_lock lock(mutex_);
      more = lines_came_.wait(lock, stop, [this] { return !waiting_.empty(); });
      text.swap(waiting_);
    }
    file_ << text << std::flush;
  }
}

void EventFile::write(const sim::N1Event& event) {
  write_line({{"t_s", since_start_s(event.at)}, {"what", event.what}, {"name", event.name}, {"value", event.value}});
}

void EventFile::write_truth(core::TimePoint now, const sim::VehicleState& state) {
  if (now < next_truth_) {
    return;
  }
  next_truth_ += kTruthPeriod;
  if (next_truth_ <= now) {
    next_truth_ = now + kTruthPeriod;  // the machine delayed us
  }
  const core::Vector<double, 3>& p = state.position_w_m;
  const core::Vector<double, 3>& v = state.velocity_w_m_s;
  const core::Euler<double> attitude = core::euler_of(state.rotation_wb);
  write_line({{"t_s", since_start_s(now)},
              {"what", "truth"},
              {"x_m", p.x()},
              {"y_m", p.y()},
              {"z_m", p.z()},
              {"vx_m_s", v.x()},
              {"vy_m_s", v.y()},
              {"vz_m_s", v.z()},
              {"roll_rad", attitude.roll_rad},
              {"pitch_rad", attitude.pitch_rad}});
}

void EventFile::summarise(core::TimePoint now, const sim::N1Autopilot& autopilot, core::Duration longest_lag) {
  const sim::N1Record& record = autopilot.record();
  const protocol::ParserStats& parser = autopilot.parser_stats();
  write_line(
      {{"t_s", since_start_s(now)},
       {"what", "summary"},
       {"obtain_requests", record.obtain_requests},
       {"least_obtain_spacing_s", spacing_s(record.min_obtain_spacing)},
       {"virtual_rc_on_requests", record.virtual_rc_on_requests},
       {"least_on_spacing_s", spacing_s(record.min_on_spacing)},
       {"movement_taken", record.movement_taken},
       {"movement_ignored", record.movement_ignored},
       {"virtual_rc_taken", record.virtual_rc_taken},
       {"virtual_rc_ignored", record.virtual_rc_ignored},
       {"most_commands_per_s", record.max_commands_per_s},
       {"losses", record.losses},
       {"control_after_loss", record.control_after_loss},
       {"latest_after_loss_s", core::seconds<double>(record.latest_after_loss)},
       {"telemetry_packages", record.telemetry_packages},
       {"bad_commands", record.bad_commands},
       {"frames", parser.frames},
       {"crc16_errors", parser.crc16_errors},
       {"crc32_errors", parser.crc32_errors},
       {"bytes_dropped", parser.bytes_dropped},
       {"longest_lag_s", core::seconds<double>(longest_lag)},
       {"client_in_control", autopilot.client_in_control()},
       {"virtual_rc_on", autopilot.virtual_rc_on()},
       {"transmitter_since_s",
        autopilot.transmitter_in_control() ? Json(since_start_s(autopilot.transmitter_since())) : Json(nullptr)}});
  if (writer_.joinable()) {
    writer_.request_stop();
    writer_.join();
  }
  expect_written();
}

}  // namespace m100::lab::autopilot
