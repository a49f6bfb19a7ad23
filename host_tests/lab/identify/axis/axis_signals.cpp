// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/axis/axis_signals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include "host_tests/lab/identify/log_defects.h"
#include "host_tests/lab/identify/log_ground.h"
#include "host_tests/lab/identify/log_units.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {
namespace {

using logs::Signal;

constexpr double kStart_s = 0.06;       // before a range, from which the state at its begin is read
constexpr double kMemory_s = 1.0;       // before a range, in which a spoilt stick still shows
constexpr double kInputMemory_s = 0.3;  // after a gap, what the delayed stick was is not known for so long

struct Choice {
  const char* axis;
  Signal stick, command;  ///< counts, or SI units
  Signal other, other_command;
  Signal response;
  Signal integral;  ///< its slope stands in for a response that was not logged
};

constexpr Choice kChoices[] = {
    {"roll", Signal::kStickRoll, Signal::kCommandRoll, Signal::kStickPitch, Signal::kCommandPitch,
     Signal::kAttitudeRoll, Signal::kCount},
    {"pitch", Signal::kStickPitch, Signal::kCommandPitch, Signal::kStickRoll, Signal::kCommandRoll,
     Signal::kAttitudePitch, Signal::kCount},
    {"yaw_rate", Signal::kStickYaw, Signal::kCommandYawRate, Signal::kCount, Signal::kCount, Signal::kRateZ,
     Signal::kAttitudeYaw},
    {"climb", Signal::kStickThrottle, Signal::kCommandClimb, Signal::kCount, Signal::kCount, Signal::kVelocityZ,
     Signal::kPositionZ},
};

// Central difference over +-5 samples: noise of a position divided by ten sample periods.
std::vector<double> slope(const std::vector<double>& values, double period_s) {
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t from = i > 5 ? i - 5 : 0;
    const std::size_t to = std::min(values.size() - 1, i + 5);
    out[i] = to > from ? (values[to] - values[from]) / (static_cast<double>(to - from) * period_s) : 0.0;
  }
  return out;
}

bool has(const logs::FlightLog& log, Signal signal) { return signal != Signal::kCount && log.has(signal); }

std::vector<double> slice(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  return {values.begin() + static_cast<std::ptrdiff_t>(begin), values.begin() + static_cast<std::ptrdiff_t>(end)};
}

template <typename Function>
std::vector<double> map(const std::vector<double>& values, Function&& function) {
  std::vector<double> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), function);
  return out;
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::multiplies<>());
  return out;
}

// Lags reach into the samples before `begin`: made on those that they reach, then cut.
RegressorGroup lag_group(const std::string& source, const std::vector<double>& channel,
                         const std::vector<std::size_t>& lags, std::size_t begin, std::size_t end) {
  RegressorGroup group{source, {}};
  const std::size_t most = lags.empty() ? 0 : *std::max_element(lags.begin(), lags.end());
  const std::size_t from = begin > most ? begin - most : 0;
  for (const std::vector<double>& column : lagged(slice(channel, from, end), lags)) {
    group.columns.push_back(slice(column, begin - from, end - from));
  }
  return group;
}

void append(RegressorGroup& group, RegressorGroup more) {
  for (std::vector<double>& column : more.columns) {
    group.columns.push_back(std::move(column));
  }
}

// Between samples by straight lines; the last value is held.
void move_earlier(std::vector<double>& values, double samples) {
  if (!(samples > 0.0) || values.empty()) {
    return;
  }
  const auto whole = static_cast<std::size_t>(samples);
  const double part = samples - std::floor(samples);
  const std::size_t last = values.size() - 1;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double now = values[std::min(i + whole, last)];
    values[i] = now + part * (values[std::min(i + whole + 1, last)] - now);
  }
}

/// Beside a gap a stick jumps without a hand: what was held there is no sample. A tenth of a second on either side,
/// which is as far as an outlier's neighbours are looked at.
std::vector<char> beside_gaps_out(std::vector<char> used, const std::vector<std::uint8_t>& gap, double period_s) {
  constexpr double kBeside_s = 0.1;
  const auto beside = static_cast<std::size_t>(std::lround(kBeside_s / period_s));
  for (std::size_t i = 0; i < gap.size() && i < used.size(); ++i) {
    if (gap[i] != 0) {
      std::fill(used.begin() + static_cast<std::ptrdiff_t>(i - std::min(i, beside)),
                used.begin() + static_cast<std::ptrdiff_t>(std::min(i + beside + 1, used.size())), char{0});
    }
  }
  return used;
}

}  // namespace

// Deviation: over 60 lines; one signal after the other is picked and mended, each once.
AxisSignals axis_signals(const logs::FlightLog& log, const std::string& axis, const std::vector<Range>& asked,
                         double stick_earlier_s) {
  const Choice* choice =
      std::find_if(std::begin(kChoices), std::end(kChoices), [&](const Choice& one) { return axis == one.axis; });
  if (choice == std::end(kChoices)) {
    throw InputError("--axis", 0, axis, "not a stick axis; choose roll, pitch, yaw_rate or climb");
  }
  AxisSignals out;
  const bool counts = has(log, choice->stick);
  const Signal stick = counts ? choice->stick : choice->command;
  if (!has(log, stick)) {
    throw InputError(log.file, 0, std::string(logs::name_of(choice->stick)),
                     "axis " + axis + " needs this signal; the column map has neither it nor " +
                         std::string(logs::name_of(choice->command)));
  }
  out.stick_name = logs::name_of(stick);
  out.data.start_s = log.start_s;
  out.data.period_s = log.period_s;
  out.data.stick = log.of(stick);
  out.data.stick_row_s = log.row_of(stick);
  const Signal other = counts ? choice->other : choice->other_command;
  if (has(log, other)) {
    out.other_name = logs::name_of(other);
    out.data.other = log.of(other);
  }
  const auto near = [&](Signal one) {
    return beside_gaps_out(inside(log, asked, kMemory_s), log.gap_of({one}), log.period_s);
  };
  std::vector<Finding> jumps =
      repair_stick(out.data.stick, near(stick), {log.start_s, log.period_s, out.data.stick_row_s}, out.stick_name);
  if (has(log, other)) {
    const std::vector<Finding> more =
        repair_stick(out.data.other, near(other), {log.start_s, log.period_s, log.row_of(other)}, out.other_name);
    jumps.insert(jumps.end(), more.begin(), more.end());
  }
  move_earlier(out.data.stick, stick_earlier_s / log.period_s);
  move_earlier(out.data.other, stick_earlier_s / log.period_s);
  if (has(log, choice->response)) {
    out.data.measured = log.of(choice->response);
  } else if (has(log, choice->integral)) {
    out.data.measured = slope(log.of(choice->integral), log.period_s);
  } else {
    throw InputError(log.file, 0, std::string(logs::name_of(choice->response)),
                     "axis " + axis + " needs this signal; the column map has none");
  }
  out.response_name = logs::name_of(has(log, choice->response) ? choice->response : choice->integral);
  out.data.row_s = log.row_of(has(log, choice->response) ? choice->response : choice->integral);
  out.data.valid.assign(log.size, 1);
  const auto ground = ground_times(log);
  out.findings = ground_findings(ground);
  out.findings.insert(out.findings.end(), jumps.begin(), jumps.end());
  const Signal measured = has(log, choice->response) ? choice->response : choice->integral;
  mask_unusable(log, log.gap_of({stick, measured}), ground, kInputMemory_s, out.data.valid);
  for (const logs::Flight& flight : log.flights) {
    out.data.flights.push_back(flight.begin);
  }
  const auto append = [&](std::vector<Finding> more) {
    out.findings.insert(out.findings.end(), more.begin(), more.end());
  };
  std::vector<char> used = inside(log, asked, kStart_s);
  if (choice->response == Signal::kAttitudeRoll || choice->response == Signal::kAttitudePitch) {
    append(repair_units(out.data.measured, used, out.response_name));
  }
  if (out.findings.empty() || out.findings.back().what != "wrong_unit") {
    append(unit_contradictions(log, axis, asked));
  }
  const std::vector<char> wanted = used;
  std::transform(used.begin(), used.end(), out.data.valid.begin(), used.begin(), std::logical_and<>());
  append(repair_samples(out.data.measured, used, {log.start_s, log.period_s, out.data.row_s}, out.response_name));
  for (std::size_t i = 0; i < log.size; ++i) {
    out.data.valid[i] = wanted[i] != 0 ? used[i] : out.data.valid[i];
  }
  return out;
}

std::vector<RegressorGroup> axis_regressors(const logs::FlightLog& log, const AxisSignals& signals, std::size_t begin,
                                            std::size_t end) {
  const auto lag = [&](double s) { return static_cast<std::size_t>(std::lround(s / log.period_s)); };
  std::vector<std::size_t> many;
  std::vector<std::size_t> few;
  for (const double s : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0}) {
    many.push_back(lag(s));
  }
  for (const double s : {0.0, 0.1, 0.2, 0.3, 0.5, 0.8}) {
    few.push_back(lag(s));
  }
  const std::vector<double>& u = signals.data.stick;
  const auto square = [](double v) { return v * std::abs(v); };
  const auto even = [](double v) { return v * v; };
  std::vector<RegressorGroup> out;
  out.push_back(lag_group(signals.stick_name, u, many, begin, end));
  RegressorGroup powers = lag_group(signals.stick_name + " powers", map(u, square), few, begin, end);
  append(powers, lag_group("", map(u, even), few, begin, end));
  append(powers, lag_group("", map(u, [](double v) { return v * v * v; }), few, begin, end));
  out.push_back(std::move(powers));
  out.push_back(lag_group(signals.stick_name + " * its rate", product(u, slope(u, log.period_s)), few, begin, end));
  std::vector<double> time(u.size());
  for (std::size_t i = 0; i < time.size(); ++i) {
    time[i] = log.time_s(i) - 0.5 * (log.time_s(begin) + log.time_s(end));
  }
  RegressorGroup trend = lag_group("time", time, {0}, begin, end);
  append(trend, lag_group("", map(time, even), {0}, begin, end));
  out.push_back(std::move(trend));
  out.push_back(lag_group(signals.stick_name + " * time", product(u, time), few, begin, end));
  if (!signals.other_name.empty()) {
    const std::vector<double>& other = signals.data.other;
    RegressorGroup both = lag_group(signals.other_name, other, few, begin, end);
    append(both, lag_group("", map(other, square), few, begin, end));
    append(both, lag_group("", map(other, even), few, begin, end));
    out.push_back(std::move(both));
    out.push_back(lag_group(signals.stick_name + " * " + signals.other_name, product(u, other), few, begin, end));
  }
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle, Signal::kStickYaw}) {
    const std::string name(logs::name_of(signal));
    if (!has(log, signal) || name == signals.stick_name || name == signals.other_name) {
      continue;
    }
    out.push_back(lag_group(name, log.of(signal), few, begin, end));
    out.push_back(lag_group(signals.stick_name + " * " + name, product(u, log.of(signal)), few, begin, end));
  }
  for (const auto& [name, channel] : log.extra) {
    double mean = 0.0;
    for (const double value : channel) {
      mean += value / static_cast<double>(channel.size());
    }
    const std::vector<double> centred = map(channel, [mean](double v) { return v - mean; });
    RegressorGroup group = lag_group(name, centred, few, begin, end);
    append(group, lag_group("", map(centred, even), {0}, begin, end));
    out.push_back(std::move(group));
    out.push_back(lag_group(signals.stick_name + " * " + name, product(u, centred), few, begin, end));
  }
  return out;
}

std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end) {
  const double period_s = signals.data.period_s;
  const auto lag = [&](double s) { return static_cast<std::size_t>(std::lround(s / period_s)); };
  const std::vector<std::size_t> lags{lag(0.0), lag(0.15), lag(0.3), lag(0.6), lag(1.0)};
  const auto size = [](double v) { return std::abs(v); };
  const std::vector<double>& u = signals.data.stick;
  RegressorGroup group = lag_group(signals.stick_name + " activity", map(u, size), lags, begin, end);
  append(group, lag_group("", map(slope(u, period_s), size), lags, begin, end));
  return {std::move(group)};
}

}  // namespace m100::lab::identify
