// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/fly.h"
#include "firmware/companion/ground_station/telemetry_stream.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/text_line.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// Sends lines to the terminal, the log and the ground station.
class OperatorChannels final : public OperatorLog {
 public:
  OperatorChannels(log::FlightLogWriter* log, TelemetryStream& stream) : log_(log), stream_(stream) {}
  void write(core::TimePoint now, std::string_view line) override {
    TextLine timed;
    timed.add(core::seconds<double>(now.time_since_epoch()), 2).add(" s  ").add(line);
    print_line(timed.text());
    if (log_ != nullptr) {
      log_->append(now, line);
    }
    stream_.publish(line);
  }

 private:
  log::FlightLogWriter* log_;
  TelemetryStream& stream_;
};

}  // namespace m100::companion
