// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/tracking.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "firmware/safety/failsafe.h"

namespace m100::lab::flight {
namespace {

constexpr double kSettled_s = 1.0;
constexpr double kBlock_s = 2.5;  ///< as the blocks of identify: longer than the loop's slowest response
constexpr std::size_t kMinBlocks = 4;

/// Sum of squares and number of the errors of one block, of one flight or of two.
struct Block {
  std::array<double, 2> squares_m2{};
  std::array<double, 2> count{};
};
using Blocks = std::map<long, Block>;

void add(const std::vector<TrackingError>& errors, std::size_t flight, Blocks& blocks) {
  for (const TrackingError& one : errors) {
    Block& block = blocks[std::lround(std::floor(one.course_s / kBlock_s))];
    block.squares_m2[flight] += one.distance_m() * one.distance_m();
    block.count[flight] += 1.0;
  }
}

/// Root mean square of flight 0, or with `two` of flight 1 minus that of flight 0; block `without` is left out.
double statistic(const Blocks& blocks, bool two, long without) {
  Block sum;
  for (const auto& [number, block] : blocks) {
    for (std::size_t i = 0; i < 2 && number != without; ++i) {
      sum.squares_m2[i] += block.squares_m2[i];
      sum.count[i] += block.count[i];
    }
  }
  const auto rms = [&](std::size_t i) { return std::sqrt(sum.squares_m2[i] / sum.count[i]); };
  return two ? rms(1) - rms(0) : rms(0);
}

Interval jackknife(const Blocks& blocks, bool two) {
  constexpr long kNone = -1;
  const double value = blocks.empty() ? std::nan("") : statistic(blocks, two, kNone);
  const auto count = static_cast<double>(blocks.size());
  if (blocks.size() < kMinBlocks) {
    return {value, std::nan(""), std::nan("")};
  }
  std::vector<double> without;
  double mean = 0.0;
  for (const auto& [number, block] : blocks) {
    without.push_back(statistic(blocks, two, number));
    mean += without.back() / count;
  }
  double squares = 0.0;
  for (const double one : without) {
    squares += (one - mean) * (one - mean);
  }
  const double half = student_t(count - 1.0) * std::sqrt(squares * (count - 1.0) / count);
  return {value, two ? value - half : std::max(0.0, value - half), value + half};
}

/// The value at time t, linear between two ticks; `after` is the index of the first tick after t.
double at_time(const std::vector<double>& t_s, const std::vector<double>& values, std::size_t after, double t) {
  const std::size_t k = std::clamp<std::size_t>(after, 1, t_s.size() - 1);
  const double step = t_s[k] - t_s[k - 1];
  const double share = step > 0.0 ? std::clamp((t - t_s[k - 1]) / step, 0.0, 1.0) : 0.0;
  return values[k - 1] + share * (values[k] - values[k - 1]);
}

}  // namespace

double TrackingError::distance_m() const { return std::hypot(error_m[0], error_m[1], error_m[2]); }

std::vector<TrackingError> tracking_errors(const FlightSeries& flight) {
  std::vector<TrackingError> out;
  if (!flight.flew() || flight.t_s.size() < 2) {
    return out;
  }
  for (const Pose& pose : flight.poses) {
    const auto after = static_cast<std::size_t>(
        std::upper_bound(flight.t_s.begin(), flight.t_s.end(), pose.captured_s) - flight.t_s.begin());
    const auto tick = std::min(after > 0 ? after - 1 : 0, flight.state.size() - 1);
    if (pose.captured_s < flight.control_s + kSettled_s || pose.captured_s > flight.end_s ||
        !safety::passes_law(static_cast<safety::FailsafeState>(flight.state[tick]))) {
      continue;
    }
    TrackingError one{.course_s = pose.captured_s - flight.control_s, .error_m = {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      one.error_m[axis] = pose.position_m[axis] - at_time(flight.t_s, flight.reference_m[axis], after, pose.captured_s);
    }
    out.push_back(one);
  }
  return out;
}

Tracking tracking_of(const std::vector<TrackingError>& errors) {
  Tracking out;
  out.poses = errors.size();
  double horizontal_m2 = 0.0;
  double vertical_m2 = 0.0;
  for (const TrackingError& one : errors) {
    horizontal_m2 += one.error_m[0] * one.error_m[0] + one.error_m[1] * one.error_m[1];
    vertical_m2 += one.error_m[2] * one.error_m[2];
    if (one.distance_m() > out.max_m) {
      out.max_m = one.distance_m();
      out.max_at_s = one.course_s;
    }
  }
  Blocks blocks;
  add(errors, 0, blocks);
  out.rms_m = jackknife(blocks, false);
  const double count = std::max(1.0, static_cast<double>(errors.size()));
  out.horizontal_rms_m = std::sqrt(horizontal_m2 / count);
  out.vertical_rms_m = std::sqrt(vertical_m2 / count);
  return out;
}

PairedErrors compare_pair(const std::vector<TrackingError>& before, const std::vector<TrackingError>& after) {
  Blocks blocks;
  add(before, 0, blocks);
  add(after, 1, blocks);
  std::erase_if(blocks, [](const auto& one) { return one.second.count[0] == 0.0 || one.second.count[1] == 0.0; });
  return {1, tracking_of(before).rms_m.value, tracking_of(after).rms_m.value, jackknife(blocks, true)};
}

std::vector<TrackingError> along(std::vector<TrackingError> errors, const std::array<double, 3>& axes) {
  for (TrackingError& one : errors) {
    one.error_m = {axes[0] * one.error_m[0], axes[1] * one.error_m[1], axes[2] * one.error_m[2]};
  }
  return errors;
}

}  // namespace m100::lab::flight
