// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/axis_signals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host_tests/lab/identify/data/ground_time.h"
#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/identify/data/unit_consistency.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {
namespace {

using logs::Signal;

constexpr double kStart_s = 0.06;       // before a range: samples that give its initial state
constexpr double kMemory_s = 1.0;       // before a range: a spoilt stick still affects the response
constexpr double kInputMemory_s = 0.3;  // after a gap: the delayed stick is unknown

struct Choice {
  const char* axis;
  Signal stick, command;  ///< in counts; in SI units
  Signal other, other_command;
  Signal response;
  Signal integral;  ///< its slope replaces a response that was not logged
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

bool has(const logs::FlightLog& log, Signal signal) { return signal != Signal::kCount && log.has(signal); }

/// `used` without the gaps and without 0.1 s on either side of each. A stick that jumps at a gap is no outlier: the log
/// holds or interpolates it there.
std::vector<char> exclude_gap_edges(std::vector<char> used, const std::vector<std::uint8_t>& gap, double period_s) {
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

/// The signals of a log that were selected for an axis; kCount: none.
struct AxisChannels {
  Signal stick;
  Signal other;
  Signal response;
  bool is_integral;  ///< `response` is the integral of the axis' response
};

/// @throws InputError naming the missing signal.
AxisChannels pick(const logs::FlightLog& log, const std::string& axis) {
  const Choice* choice =
      std::find_if(std::begin(kChoices), std::end(kChoices), [&](const Choice& one) { return axis == one.axis; });
  if (choice == std::end(kChoices)) {
    throw InputError("--axis", 0, axis, "not a stick axis; choose roll, pitch, yaw_rate or climb");
  }
  const bool counts = has(log, choice->stick);
  const Signal stick = counts ? choice->stick : choice->command;
  if (!has(log, stick)) {
    throw InputError(log.columns, 0, std::string(logs::name_of(choice->stick)),
                     "axis " + axis + " needs this signal; the column map has neither it nor " +
                         std::string(logs::name_of(choice->command)));
  }
  const bool is_integral = !has(log, choice->response);
  const Signal response = is_integral ? choice->integral : choice->response;
  if (!has(log, response)) {
    throw InputError(log.columns, 0, std::string(logs::name_of(choice->response)),
                     "axis " + axis + " needs this signal; the column map has none");
  }
  const Signal other = counts ? choice->other : choice->other_command;
  return {stick, has(log, other) ? other : Signal::kCount, response, is_integral};
}

void append(std::vector<Finding> more, AxisSignals& out) {
  out.findings.insert(out.findings.end(), more.begin(), more.end());
}

/// Takes the axis' stick and the other stick from the log, repairs them and reads them by their clock.
void read_sticks(const logs::FlightLog& log, const AxisChannels& picked, const std::vector<Range>& requested,
                 const StickClock& clock, AxisSignals& out) {
  const auto repaired = [&](Signal stick, std::vector<double>& counts, std::string& name) {
    name = logs::name_of(stick);
    counts = log.of(stick);
    const auto near = exclude_gap_edges(mask_ranges(log, requested, kMemory_s), log.gap_of({stick}), log.period_s);
    append(repair_stick(counts, near, {log.start_s, log.period_s, log.row_of(stick)}, name), out);
    read_at_times(counts, clock.earlier_s / log.period_s, clock.rate);
  };
  out.data.stick_row_s = log.logged_row_of(picked.stick);
  repaired(picked.stick, out.data.stick, out.stick_name);
  if (picked.other != Signal::kCount) {
    repaired(picked.other, out.data.other, out.other_name);
  }
}

void read_response(const logs::FlightLog& log, const AxisChannels& picked, AxisSignals& out) {
  const std::vector<double>& logged = log.of(picked.response);
  out.data.measured = picked.is_integral ? derivative(logged, log.period_s) : logged;
  out.data.row_s = log.row_of(picked.response);
  out.response_name = logs::name_of(picked.response);
}

/// Converts an attitude in degrees, reports contradicting units, excludes frozen samples and replaces outliers.
void repair_response(const logs::FlightLog& log, const std::string& axis, const AxisChannels& picked,
                     const std::vector<Range>& requested, AxisSignals& out) {
  std::vector<char> used = mask_ranges(log, requested, kStart_s);
  if (picked.response == Signal::kAttitudeRoll || picked.response == Signal::kAttitudePitch) {
    append(repair_units(out.data.measured, used, out.response_name), out);
  }
  if (out.findings.empty() || out.findings.back().what != "wrong_unit") {
    append(unit_contradictions(log, axis, requested), out);
  }
  const std::vector<char> wanted = used;
  std::transform(used.begin(), used.end(), out.data.valid.begin(), used.begin(), std::logical_and<>());
  append(repair_samples(out.data.measured, used, {log.start_s, log.period_s, out.data.row_s}, out.response_name), out);
  for (std::size_t i = 0; i < log.size; ++i) {
    out.data.valid[i] = wanted[i] != 0 ? used[i] : out.data.valid[i];
  }
}

}  // namespace

void read_at_times(std::vector<double>& values, double earlier, double rate) {
  if ((earlier == 0.0 && rate == 0.0) || values.empty()) {
    return;
  }
  const std::vector<double> logged = values;
  const auto last = static_cast<double>(values.size() - 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto at = static_cast<double>(i);
    const double from = std::clamp(at + earlier + rate * (at - 0.5 * last), 0.0, last);
    const auto whole = static_cast<std::size_t>(from);
    const double next = logged[std::min(whole + 1, logged.size() - 1)];
    values[i] = logged[whole] + (from - std::floor(from)) * (next - logged[whole]);
  }
}

double central_difference(const std::vector<double>& values, std::size_t sample, double period_s) {
  const std::size_t from = sample > 5 ? sample - 5 : 0;
  const std::size_t to = std::min(values.size() - 1, sample + 5);
  return to > from ? (values[to] - values[from]) / (static_cast<double>(to - from) * period_s) : 0.0;
}

std::vector<double> derivative(const std::vector<double>& values, double period_s) {
  constexpr std::size_t kHalf = 9;
  // Sums over k = -9..9 of k^2, k^4 and k^6, in the normal equations of the cubic's odd terms.
  constexpr double kS2 = 570.0;
  constexpr double kS4 = 30666.0;
  constexpr double kS6 = 1956810.0;
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i < kHalf || i + kHalf >= values.size()) {
      out[i] = central_difference(values, i, period_s);
      continue;
    }
    double first = 0.0;
    double third = 0.0;
    for (std::size_t k = 1; k <= kHalf; ++k) {
      const auto way = static_cast<double>(k);
      const double odd = values[i + k] - values[i - k];
      first += way * odd;
      third += way * way * way * odd;
    }
    out[i] = (kS6 * first - kS4 * third) / ((kS2 * kS6 - kS4 * kS4) * period_s);
  }
  return out;
}

AxisSignals axis_signals(const logs::FlightLog& log, const std::string& axis, const std::vector<Range>& requested,
                         const StickClock& clock) {
  const AxisChannels picked = pick(log, axis);
  AxisSignals out;
  out.data.start_s = log.start_s;
  out.data.period_s = log.period_s;
  for (const logs::Flight& flight : log.flights) {
    out.data.flights.push_back(flight.begin);
  }
  const auto ground = ground_times(log);
  out.findings = ground_findings(ground);
  read_sticks(log, picked, requested, clock, out);
  read_response(log, picked, out);
  out.data.valid.assign(log.size, 1);
  mask_unusable(log, log.gap_of({picked.stick, picked.response}), ground, kInputMemory_s, out.data.valid);
  repair_response(log, axis, picked, requested, out);
  return out;
}

}  // namespace m100::lab::identify
