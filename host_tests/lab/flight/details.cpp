// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/details.h"

#include <algorithm>

#include "host_tests/lab/flight/figures.h"
#include "host_tests/lab/flight/tracking.h"

namespace m100::lab::flight {
namespace {

constexpr std::array kAxisNames{"x", "y", "z"};
/// Colours of two curves, of the flight before and of the flight after or the only one.
constexpr std::array<std::array<const char*, 2>, 2> kColors{
    {{plot::kOrange, plot::kPurple}, {plot::kBlue, plot::kBlack}}};

const std::array<const char*, 2>& colors_of(const Flights& flights, std::size_t f) {
  return kColors[flights.size() > 1 ? f : 1];
}

void failsafe_steps(const Flights& flights, plot::Page& page) {
  std::vector<std::vector<std::string>> rows{{"time [s]", "failsafe", "reason"}};
  for (std::size_t f = 0; f < flights.size(); ++f) {
    for (const FailsafeChange& step : flights[f].changes) {
      rows.push_back(
          {plot::number(shown_s(flights, f, step.t_s)), which(flights, f) + step.from + " to " + step.to, step.reason});
    }
  }
  if (rows.size() > 1) {
    page.table(rows);
  }
}

void error_by_axis(const Flights& flights, plot::Page& page) {
  std::vector<std::vector<TrackingError>> errors;
  for (const FlightSeries& flight : flights) {
    errors.push_back(tracking_errors(flight));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    plot::Figure figure = over_time(flights, std::string("Error along ") + kAxisNames[axis], "pose minus course [m]");
    for (std::size_t f = 0; f < flights.size(); ++f) {
      figure.lines.push_back(error_curve(flights, f, "error", colors_of(flights, f)[0], errors[f],
                                         [axis](const TrackingError& one) { return one.error_m[axis]; }));
    }
    figure.levels = {{0.0, ""}};
    page.figure(figure, "");
  }
}

void attitude(const Flights& flights, plot::Page& page) {
  constexpr std::array kNames{"Roll", "Pitch"};
  for (std::size_t axis = 0; axis < kNames.size(); ++axis) {
    plot::Figure figure = over_time(flights, kNames[axis], "[deg]");
    for (std::size_t f = 0; f < flights.size(); ++f) {
      figure.lines.push_back(curve(flights, f, "measured", flights[f].attitude_t_s, flights[f].attitude_rad[axis],
                                   colors_of(flights, f)[0], core::kRadian_deg));
      if (!flights[f].is_recording) {
        figure.lines.push_back(
            tick_curve(flights, f, "command", flights[f].granted[axis], core::kRadian_deg, colors_of(flights, f)[1]));
      }
    }
    page.figure(figure, "");
  }
}

void disturbance(const Flights& flights, plot::Page& page) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    plot::Figure figure = over_time(flights, std::string("Disturbance along ") + kAxisNames[axis], "[m/s²]");
    for (std::size_t f = 0; f < flights.size(); ++f) {
      figure.lines.push_back(
          tick_curve(flights, f, "believed", flights[f].disturbance_m_s2[axis], 1.0, colors_of(flights, f)[0]));
      figure.lines.push_back(
          tick_curve(flights, f, "found", flights[f].found_disturbance_m_s2[axis], 1.0, colors_of(flights, f)[1]));
    }
    page.figure(figure,
                "Believed: by the observer, in flight. Found: afterwards, the acceleration of the poses within half a "
                "second, minus what tilt and drag explain.");
  }
}

void residual_and_timing(const Flights& flights, plot::Page& page) {
  plot::Figure residual = over_time(flights, "Residual", "over what is expected");
  plot::Figure timing = over_time(flights, "Timing", "[ms]");
  plot::Figure vibration = over_time(flights, "Vibration", "above 15 Hz, of an axis [m/s²]");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const auto& colors = colors_of(flights, f);
    residual.lines.push_back(tick_curve(flights, f, "residual", flights[f].residual, 1.0, colors[0]));
    if (!flights[f].vibration_m_s2.empty()) {
      vibration.lines.push_back(tick_curve(flights, f, "rms", flights[f].vibration_m_s2, 1.0, colors[0]));
      vibration.lines.push_back(tick_curve(flights, f, "peak", flights[f].vibration_peak_m_s2, 1.0, colors[1]));
    }
    timing.lines.push_back(tick_curve(flights, f, "age of telemetry", flights[f].telemetry_age_s, 1e3, colors[0]));
    timing.lines.push_back(tick_curve(flights, f, "tick late by", flights[f].late_s, 1e3, colors[1]));
  }
  residual.levels = {{0.0, ""}, {1.0, "expected"}};
  const bool has_block = std::any_of(flights.back().residual.begin(), flights.back().residual.end(),
                                     [](double ratio) { return ratio > 0.0; });
  if (has_block) {
    page.figure(residual, "Of the axis that follows its model worst, at the end of each block of 2.5 s.");
  }
  page.figure(timing, "");
  vibration.levels = {{0.03, "healthy M100"}};
  if (!vibration.lines.empty()) {
    page.figure(vibration, "");
  }
}

/// Prediction errors: one row per quantity and flight.
void predictions(const Flights& flights, plot::Page& page) {
  std::vector<std::vector<std::string>> rows{
      {"each flight's prediction by its own vehicle file, rms", "0.2 s ahead", "0.5 s", "1 s", "2 s"}};
  for (std::size_t f = 0; f < flights.size(); ++f) {
    for (const PredictionRow& one : flights[f].predictions) {
      rows.push_back({which(flights, f) + one.quantity});
      for (const double error : one.errors) {
        rows.back().push_back(plot::number(error));
      }
    }
  }
  if (rows.size() > 1) {
    page.table(rows);
    page.paragraph(
        "Each prediction starts from the measured state and knows only the sticks after it. The vehicle file is the "
        "one "
        "that the flight's own log holds.");
  }
}

}  // namespace

void add_details(const Flights& flights, plot::Page& page) {
  page.heading("In detail");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    for (const std::string& note : flights[f].notes) {
      page.paragraph(which(flights, f) + note);
    }
  }
  const bool flew = flights.front().flew();
  failsafe_steps(flights, page);
  predictions(flights, page);
  page.begin_grid();
  if (flew) {
    error_by_axis(flights, page);
  }
  attitude(flights, page);
  if (!flights.front().battery_percent.values.empty()) {
    page.figure(battery_figure(flights), "");
  }
  if (flew) {
    disturbance(flights, page);
    residual_and_timing(flights, page);
    page.figure(stick_figure(flights), flights.size() > 1 ? "As sent in the flight after." : "As sent.");
  }
  page.end_grid();
}

}  // namespace m100::lab::flight
