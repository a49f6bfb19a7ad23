// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/figures.h"

#include <algorithm>
#include <cmath>

#include "firmware/safety/failsafe.h"

namespace m100::lab::flight {
namespace {

constexpr double kHeight_px = 200.0;
constexpr std::size_t kPathPoints = 1500;
constexpr double kGap_s = 0.5;  ///< no value for so long: the curve breaks

const char* color_of(const Flights& flights, std::size_t flight) {
  return flights.size() > 1 && flight == 0 ? plot::kOrange : plot::kBlue;
}

const char* color_of_state(safety::FailsafeState state) {
  return state == safety::FailsafeState::kCoast     ? "#fff3d6"
         : state == safety::FailsafeState::kLevel   ? "#fbd9bd"
         : state == safety::FailsafeState::kRelease ? "#f3c6c6"
                                                    : "#ececec";
}

/// The state of the failsafe in the ticks [begin, end) of flight f. Empty: nominal, or, with several flights, outside
/// of the time in which the law flew.
std::optional<plot::Span> state_span(const Flights& flights, std::size_t f, std::size_t begin, std::size_t end) {
  const FlightSeries& flight = flights[f];
  const auto state = static_cast<safety::FailsafeState>(flight.state[begin]);
  const double from_s = flight.t_s[begin];
  const double to_s = end < flight.t_s.size() ? flight.t_s[end] : flight.t_s.back();
  const bool outside = flights.size() > 1 && (to_s <= flight.control_s || from_s >= flight.end_s);
  if (state == safety::FailsafeState::kNominal || outside) {
    return std::nullopt;
  }
  std::string label = which(flights, f) + std::string(safety::name(state));
  for (const FailsafeChange& step : flight.changes) {
    label += step.t_s == from_s && !step.reason.empty() ? ": " + step.reason : "";
  }
  return plot::Span{shown_s(flights, f, from_s), shown_s(flights, f, to_s), label, color_of_state(state)};
}

/// The spans of all flights in which the failsafe is not nominal.
std::vector<plot::Span> state_spans(const Flights& flights) {
  std::vector<plot::Span> out;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const std::vector<std::uint8_t>& state = flights[f].state;
    for (std::size_t begin = 0, end = 0; begin < state.size(); begin = end) {
      while (end < state.size() && state[end] == state[begin]) {
        ++end;
      }
      if (const std::optional<plot::Span> span = state_span(flights, f, begin, end)) {
        out.push_back(*span);
      }
    }
  }
  return out;
}

/// Every n-th point of a path while the control law flew; of a pilot's recording, of the whole path.
plot::Curve path_curve(const Flights& flights, std::size_t f, const Axes& of, std::size_t across, std::size_t up) {
  const FlightSeries& flight = flights[f];
  plot::Curve out{.name = which(flights, f) + "flown", .color = color_of(flights, f)};
  const std::size_t step = std::max<std::size_t>(1, flight.t_s.size() / kPathPoints);
  for (std::size_t k = 0; k < flight.t_s.size(); k += step) {
    if (flight.is_recording || (flight.t_s[k] >= flight.control_s && flight.t_s[k] <= flight.end_s)) {
      out.x.push_back(of[across][k]);
      out.y.push_back(of[up][k]);
      out.t_s.push_back(shown_s(flights, f, flight.t_s[k]));
    }
  }
  return out;
}

double size_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return values.empty() ? 0.0 : *high - *low;
}

/// Adds the fence as a box, unless the flight spans less than kSmallest of it.
void add_fence(const FlightSeries& flight, std::size_t across, std::size_t up, plot::Figure& figure) {
  constexpr double kSmallest = 0.1;  // of the fence
  if (!flight.fence) {
    return;
  }
  const core::Fence::Side& x = flight.fence->side[across];
  const core::Fence::Side& y = flight.fence->side[up];
  const double flown = std::max(size_of(figure.lines.front().x), size_of(figure.lines.front().y));
  if (flown > kSmallest * std::max(x.high_m - x.low_m, y.high_m - y.low_m)) {
    figure.lines.push_back({.name = "fence",
                            .x = {x.low_m, x.high_m, x.high_m, x.low_m, x.low_m},
                            .y = {y.low_m, y.low_m, y.high_m, y.high_m, y.low_m},
                            .color = plot::kGrey,
                            .dashed = true});
  }
}

plot::Figure path(const Flights& flights, std::size_t across, std::size_t up, const char* title) {
  constexpr std::array kNames{"x [m]", "y [m]", "z [m]"};
  plot::Figure figure{.title = title,
                      .x_label = kNames[across],
                      .y_label = kNames[up],
                      .equal_axes = true,
                      .width = 420.0,
                      .height = 260.0,
                      .link = "flight"};
  for (std::size_t f = 0; f < flights.size(); ++f) {
    figure.lines.push_back(path_curve(flights, f, flights[f].position_m, across, up));
  }
  if (!flights.front().is_recording) {
    plot::Curve course = path_curve(flights, 0, flights.front().reference_m, across, up);
    course.name = "course";
    course.color = plot::kBlack;
    course.dashed = true;
    course.t_s.clear();
    figure.lines.push_back(std::move(course));
  }
  add_fence(flights.front(), across, up, figure);
  return figure;
}

}  // namespace

std::string which(const Flights& flights, std::size_t flight) {
  return flights.size() < 2 ? "" : flight == 0 ? "before, " : "after, ";
}

double shown_s(const Flights& flights, std::size_t flight, double t_s) {
  return flights.size() < 2 ? t_s : t_s - flights[flight].control_s;
}

plot::Figure over_time(const Flights& flights, const std::string& title, const std::string& y_label) {
  plot::Figure figure{.title = title,
                      .x_label = flights.size() < 2 ? "time since the log's begin [s]" : "time on the course [s]",
                      .y_label = y_label,
                      .spans = state_spans(flights),
                      .height = kHeight_px,
                      .link = "flight"};
  if (flights.front().flew()) {  // with a second before and after, to see how it began and ended
    double last_s = 0.0;
    for (std::size_t f = 0; f < flights.size(); ++f) {
      last_s = std::max(last_s, shown_s(flights, f, flights[f].end_s) + 1.0);
    }
    figure.x_range = std::pair{shown_s(flights, 0, flights.front().control_s) - 1.0, last_s};
  }
  return figure;
}

plot::Curve curve(const Flights& flights, std::size_t flight, const std::string& name, const std::vector<double>& t_s,
                  const std::vector<double>& values, const char* color, double scale) {
  plot::Curve out{.name = which(flights, flight) + name, .color = color, .max_step = kGap_s};
  for (std::size_t k = 0; k < std::min(values.size(), t_s.size()); ++k) {
    out.x.push_back(shown_s(flights, flight, t_s[k]));
    out.y.push_back(scale * values[k]);
  }
  return out;
}

plot::Curve tick_curve(const Flights& flights, std::size_t flight, const std::string& name,
                       const std::vector<double>& values, double scale, const char* color) {
  return curve(flights, flight, name, flights[flight].t_s, values, color, scale);
}

plot::Curve error_curve(const Flights& flights, std::size_t flight, const std::string& name, const char* color,
                        const std::vector<TrackingError>& errors,
                        const std::function<double(const TrackingError&)>& value) {
  plot::Curve out{.name = which(flights, flight) + name, .color = color, .max_step = kGap_s};
  for (const TrackingError& one : errors) {
    out.x.push_back(shown_s(flights, flight, one.course_s + flights[flight].control_s));
    out.y.push_back(value(one));
  }
  return out;
}

plot::Figure path_from_above(const Flights& flights) { return path(flights, 0, 1, "From above"); }

plot::Figure path_from_the_side(const Flights& flights) {
  const Axes& at = flights.front().position_m;
  return path(flights, size_of(at[0]) >= size_of(at[1]) ? 0 : 1, 2, "From the side");
}

std::string fence_words(const FlightSeries& flight) {
  if (!flight.fence) {
    return flight.is_recording ? "" : "The log holds no fence.";
  }
  double nearest_m = 1e9;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < flight.t_s.size(); ++k) {
      if (flight.t_s[k] >= flight.control_s && flight.t_s[k] <= flight.end_s) {
        const double at = flight.position_m[axis][k];
        nearest_m = std::min({nearest_m, at - flight.fence->side[axis].low_m, flight.fence->side[axis].high_m - at});
      }
    }
  }
  return "Least distance to a side of the fence: " + plot::number(nearest_m) + " m.";
}

plot::Figure distance_figure(const Flights& flights) {
  plot::Figure figure = over_time(flights, "Distance from the course", "[m]");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const std::vector<TrackingError> errors = tracking_errors(flights[f]);
    const double rms_m = tracking_of(errors).rms_m.value;
    if (std::isfinite(rms_m)) {
      figure.levels.emplace_back(rms_m, flights.size() > 1 ? "" : "rms");
    }
    figure.lines.push_back(
        error_curve(flights, f, "distance", color_of(flights, f), errors, &TrackingError::distance_m));
  }
  figure.levels.emplace_back(0.0, "");
  return figure;
}

plot::Figure failsafe_figure(const Flights& flights) {
  using safety::FailsafeState;
  constexpr std::array kDown{FailsafeState::kSilent, FailsafeState::kRelease, FailsafeState::kLevel,
                             FailsafeState::kCoast, FailsafeState::kNominal};
  plot::Figure figure = over_time(flights, "Failsafe", "state and reason");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    std::vector<double> height;
    for (const std::uint8_t state : flights[f].state) {
      height.push_back(static_cast<double>(std::find(kDown.begin(), kDown.end(), static_cast<FailsafeState>(state)) -
                                           kDown.begin()));
    }
    figure.lines.push_back(tick_curve(flights, f, "state", height, 1.0, color_of(flights, f)));
    figure.lines.back().width = 2.4;
  }
  for (std::size_t i = 0; i < kDown.size(); ++i) {
    figure.levels.emplace_back(static_cast<double>(i), std::string(safety::name(kDown[i])));
  }
  figure.y_range = std::pair{-0.5, 4.9};
  return figure;
}

plot::Figure command_figure(const Flights& flights) {
  plot::Figure figure = over_time(flights, "Commands", "tilt [deg]");
  constexpr std::array<std::array<const char*, 2>, 2> kCommandColors{
      {{plot::kBlue, plot::kGreen}, {plot::kOrange, plot::kPurple}}};
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const auto& colors = kCommandColors[flights.size() > 1 && f == 0 ? 1 : 0];
    figure.lines.push_back(tick_curve(flights, f, "roll", flights[f].granted[0], core::kRadian_deg, colors[0]));
    figure.lines.push_back(tick_curve(flights, f, "pitch", flights[f].granted[1], core::kRadian_deg, colors[1]));
  }
  const double limit_deg = core::kRadian_deg * flights.front().tilt_limit_rad;
  figure.levels = {{limit_deg, "limit"}, {-limit_deg, ""}};
  return figure;
}

plot::Figure pose_figure(const Flights& flights) {
  plot::Figure figure = over_time(flights, "Pose", "[ms]");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    plot::Curve latency{.name = which(flights, f) + "latency", .color = color_of(flights, f), .max_step = kGap_s};
    plot::Curve interval = latency;
    interval.name = which(flights, f) + "interval";
    interval.color = f == 0 && flights.size() > 1 ? plot::kPurple : plot::kGreen;
    const std::vector<Pose>& poses = flights[f].poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double at_s = shown_s(flights, f, poses[i].t_s);
      latency.x.push_back(at_s);
      latency.y.push_back(1e3 * (poses[i].t_s - poses[i].captured_s));
      interval.x.push_back(at_s);
      interval.y.push_back(i > 0 ? 1e3 * (poses[i].t_s - poses[i - 1].t_s) : std::nan(""));
    }
    figure.lines.push_back(std::move(latency));
    figure.lines.push_back(std::move(interval));
  }
  figure.levels = {{0.0, ""}};
  return figure;
}

plot::Figure battery_figure(const Flights& flights) {
  plot::Figure figure = over_time(flights, "Battery", "charge [%]");
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const Timed& charge = flights[f].battery_percent;
    figure.lines.push_back(curve(flights, f, "charge", charge.t_s, charge.values, color_of(flights, f), 1.0));
    figure.lines.back().max_step = std::numeric_limits<double>::infinity();  // logged when it changes
  }
  figure.y_range = std::pair{0.0, 105.0};
  return figure;
}

plot::Figure stick_figure(const Flights& flights) {
  constexpr std::array kNames{"roll", "pitch", "throttle", "yaw"};
  constexpr std::array kStickColors{plot::kBlue, plot::kOrange, plot::kGreen, plot::kPurple};
  const bool by_hand = flights.back().is_recording;
  plot::Figure figure = over_time(flights, "Sticks", by_hand ? "of the pilot, 10000 is full travel" : "[counts]");
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const Timed& stick = flights.back().sticks_counts[i];
    figure.lines.push_back(
        curve(flights, flights.size() - 1, kNames[i], stick.t_s, stick.values, kStickColors[i], 1.0));
    figure.lines.back().name = kNames[i];
  }
  return figure;
}

}  // namespace m100::lab::flight
