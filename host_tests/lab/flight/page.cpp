// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/page.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/flight/details.h"
#include "host_tests/lab/flight/figures.h"
#include "host_tests/lab/flight/tracking.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab::flight {
namespace {

using plot::number;

std::string with_interval(const Interval& one) {
  const std::string interval = " [" + number(one.low) + ", " + number(one.high) + "]";
  return number(one.value) + " m" + (std::isnan(one.low) ? "" : interval);
}

/// The first steps of the failsafe with their reasons, because the figure has no room for them.
std::string step_words(const std::vector<FlightSeries>& flights) {
  constexpr std::size_t kMaxSteps = 6;
  std::string out;
  std::size_t count = 0;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    for (const FailsafeChange& step : flights[f].changes) {
      if (++count <= kMaxSteps) {
        out += (out.empty() ? "" : "; ") + which(flights, f) + number(shown_s(flights, f, step.t_s)) + " s " + step.to +
               (step.reason.empty() ? "" : ": " + step.reason);
      }
    }
  }
  return out + (count > kMaxSteps ? "; " + std::to_string(count - kMaxSteps) + " more below" : "");
}

/// What ended the law's flight, and how often it coasted before. If the law did not fly: the failsafe's last state.
std::string failsafe_words(const FlightSeries& flight) {
  if (!flight.flew()) {
    return flight.changes.empty()
               ? "the failsafe made no step"
               : "the failsafe ended at " + flight.changes.back().to + ": " + flight.changes.back().reason;
  }
  std::size_t coasts = 0;
  std::string end = "flew until the log's end";
  for (const FailsafeChange& step : flight.changes) {
    coasts += step.to == "coast" ? 1U : 0U;
    if ((step.from == "nominal" || step.from == "coast") && step.to != "nominal" && step.to != "coast") {
      end = "then " + step.to + (step.reason.empty() ? "" : ": " + step.reason);
    }
  }
  return end + (coasts > 0 ? ", coasted " + std::to_string(coasts) + " times before" : "");
}

plot::Page::Tile pose_tile(const FlightSeries& flight) {
  std::vector<double> latency_ms, interval_s;
  for (std::size_t i = 0; i < flight.poses.size(); ++i) {
    latency_ms.push_back(1e3 * (flight.poses[i].t_s - flight.poses[i].captured_s));
    if (i > 0) {
      interval_s.push_back(flight.poses[i].t_s - flight.poses[i - 1].t_s);
    }
  }
  if (interval_s.empty()) {
    return {.name = "pose", .value = "none", .note = ""};
  }
  const double span_s = flight.poses.back().t_s - flight.poses.front().t_s;
  return {.name = "pose: latency, rate, loss",
          .value = number(quantile(latency_ms, 0.5)) + " ms, " +
                   number(static_cast<double>(interval_s.size()) / span_s) + " Hz" +
                   (flight.lost_share >= 0.0 ? ", " + number(100.0 * flight.lost_share) + " %" : ""),
          .note = "99 % within " + number(quantile(latency_ms, 0.99)) + " ms; longest gap " +
                  number(1e3 * *std::max_element(interval_s.begin(), interval_s.end())) + " ms; " +
                  std::to_string(flight.refused_poses) + " refused"};
}

plot::Page::Tile battery_tile(const FlightSeries& flight) {
  const std::vector<double>& charge = flight.battery_percent.values;
  return {.name = "battery",
          .value = charge.empty() ? "not reported"
                                  : std::to_string(std::lround(charge.front())) + " to " +
                                        std::to_string(std::lround(charge.back())) + " %",
          .note = ""};
}

/// The strongest while the law flew.
plot::Page::Tile vibration_tile(const FlightSeries& flight) {
  double rms_m_s2 = -1.0, peak_m_s2 = 0.0;
  for (std::size_t k = 0; k < flight.vibration_m_s2.size(); ++k) {
    if (flight.t_s[k] >= flight.control_s && flight.t_s[k] <= flight.end_s && flight.vibration_m_s2[k] > rms_m_s2) {
      rms_m_s2 = flight.vibration_m_s2[k];
      peak_m_s2 = flight.vibration_peak_m_s2[k];
    }
  }
  return {.name = "vibration above 15 Hz",
          .value = rms_m_s2 < 0.0 ? "not seen" : number(rms_m_s2) + " m/s²",
          .note = "rms of an axis, " + (rms_m_s2 < 0.0 ? "" : "peak " + number(peak_m_s2) + " m/s²; ") +
                  "a healthy M100 shows 0.02 to 0.03"};
}

plot::Page::Tile error_tile(const FlightSeries& flight, const std::string& name) {
  const Tracking error = tracking_of(tracking_errors(flight));
  return {.name = name,
          .value = error.poses == 0 ? "not flown" : with_interval(error.rms_m),
          .note = error.poses == 0
                      ? ""
                      : "largest " + number(error.max_m) + " m at " + number(error.max_at_s) + " s; horizontal " +
                            number(error.horizontal_rms_m) + ", vertical " + number(error.vertical_rms_m)};
}

/// One row of numbers for each flight.
void add_tiles(const std::vector<FlightSeries>& flights, plot::Page& page) {
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const FlightSeries& flight = flights[f];
    std::vector<plot::Page::Tile> tiles;
    if (!flight.is_recording) {
      tiles.push_back(error_tile(flight, "error, rms [95 %]"));
      tiles.push_back({.name = "failsafe",
                       .value = number(flight.end_s - flight.control_s) + " s by the law",
                       .note = failsafe_words(flight)});
    }
    tiles.push_back(pose_tile(flight));
    tiles.push_back(battery_tile(flight));
    if (flight.flew()) {
      tiles.push_back(vibration_tile(flight));
    }
    for (plot::Page::Tile& tile : tiles) {
      tile.name.insert(0, which(flights, f));
    }
    page.tiles(tiles);
  }
}

/// Good: control was given back on purpose. Bad: the law ended for another known reason. Warn: coasted, or not flown.
std::string kind_of(const std::vector<FlightSeries>& flights) {
  std::string kind = "good";
  for (const FlightSeries& flight : flights) {
    kind = flight.flew() || flight.is_recording ? kind : "warn";
    for (const FailsafeChange& step : flight.changes) {
      const bool leaves = step.from == "nominal" || step.from == "coast";
      const bool on_purpose = step.reason == "given_back" || step.reason == "task" || step.reason.empty();
      if (leaves && step.to != "nominal" && step.to != "coast" && !on_purpose) {
        return "bad";
      }
      kind = step.to == "coast" ? "warn" : kind;
    }
  }
  return kind;
}

}  // namespace

std::string error_sentence(const std::vector<FlightSeries>& flights) {
  const std::vector<TrackingError> first = tracking_errors(flights.front());
  if (flights.front().is_recording) {
    return "Recorded by hand for " + number(flights.front().end_s) + " s.";
  }
  if (!flights.front().flew()) {
    return "The law did not fly: " + failsafe_words(flights.front()) + ". There is no error to show.";
  }
  const std::vector<TrackingError> second = tracking_errors(flights.back());
  if (first.empty() || second.empty()) {
    return "The law flew less than a second: the error is counted after that.";
  }
  const Tracking before = tracking_of(first);
  if (flights.size() < 2) {
    return "Distance from the course: " + with_interval(before.rms_m) + " root mean square, " + number(before.max_m) +
           " m at most, " + std::to_string(before.poses) + " poses. The law flew " +
           number(flights.front().end_s - flights.front().control_s) + " s, " + failsafe_words(flights.front()) + ".";
  }
  return "Distance from the course, root mean square, before -> after, difference on the part that both flew: " +
         describe(compare_pair(first, second)) + ". " + paired_rule();
}

void add_first_screen(const std::vector<FlightSeries>& flights, plot::Page& page) {
  page.verdict(error_sentence(flights), kind_of(flights));
  add_tiles(flights, page);
  page.begin_grid();
  if (!flights.front().position_m[0].empty()) {
    page.figure(path_from_above(flights), fence_words(flights.front()));
    page.figure(path_from_the_side(flights), "");
  }
  if (!flights.front().is_recording) {
    if (flights.front().flew()) {
      page.figure(distance_figure(flights), "Shaded: the failsafe is not at nominal.");
      page.figure(command_figure(flights), "As sent; dashed: limit.");
    }
    page.figure(failsafe_figure(flights), step_words(flights));
  } else {
    page.figure(stick_figure(flights), "");
  }
  if (!flights.front().poses.empty()) {
    page.figure(pose_figure(flights), "From capture to arrival, and the time since the pose before.");
  }
  page.end_grid();
}

plot::Page flight_page(const std::vector<FlightSeries>& flights, const std::string& title, const std::string& note) {
  plot::Page page(title);
  if (!note.empty()) {
    page.paragraph(note);
  }
  add_first_screen(flights, page);
  add_details(flights, page);
  return page;
}

}  // namespace m100::lab::flight
