// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/score.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware/core/maths.h"
#include "firmware/model/tilt_limit.h"
#include "firmware/safety/failsafe.h"

namespace m100::lab::experiments {
namespace {

double square(double value) { return value * value; }

}  // namespace

bool stayed(const Trace& trace) {
  constexpr auto kNominal = static_cast<int>(safety::FailsafeState::kNominal);
  constexpr auto kCoast = static_cast<int>(safety::FailsafeState::kCoast);
  return !trace.empty() && std::all_of(trace.begin(), trace.end(), [](const TracePoint& point) {
    return point.failsafe_state == kNominal || point.failsafe_state == kCoast;
  });
}

Cell score(const Trace& trace, double from_s, double to_s) {
  Cell sum;
  double count = 0.0;
  double worst2 = 0.0;
  const TracePoint* before = nullptr;
  for (const TracePoint& point : trace) {
    if (point.t_s < from_s || point.t_s >= to_s) {
      continue;
    }
    const double x = square(point.position_m[0] - point.reference_m[0]);
    const double y = square(point.position_m[1] - point.reference_m[1]);
    const double z = square(point.position_m[2] - point.reference_m[2]);
    sum.x_m += x;
    sum.y_m += y;
    sum.z_m += z;
    sum.pose_m += x + y + z;
    worst2 = std::max(worst2, x + y + z);
    sum.roll_deg += square(point.roll_rad * core::kRadian_deg);
    sum.pitch_deg += square(point.pitch_rad * core::kRadian_deg);
    sum.yaw_deg +=
        square(std::remainder(point.yaw_rad - point.reference_yaw_rad, 2.0 * std::numbers::pi) * core::kRadian_deg);
    sum.tilt_deg += square(std::acos(std::cos(point.roll_rad) * std::cos(point.pitch_rad)) * core::kRadian_deg);
    sum.off_nominal_share += point.failsafe_state != 1 ? 1.0 : 0.0;
    if (before != nullptr) {
      sum.input_variation_deg_s += (std::abs(point.applied_command[0] - before->applied_command[0]) +
                                    std::abs(point.applied_command[1] - before->applied_command[1])) *
                                   core::kRadian_deg;
    }
    before = &point;
    count += 1.0;
  }
  if (count == 0.0) {
    return {};
  }
  for (double Cell::*const member : {&Cell::pose_m, &Cell::x_m, &Cell::y_m, &Cell::z_m, &Cell::roll_deg,
                                     &Cell::pitch_deg, &Cell::yaw_deg, &Cell::tilt_deg}) {
    sum.*member = std::sqrt(sum.*member / count);
  }
  sum.input_variation_deg_s /= to_s - from_s;
  sum.worst_m = std::sqrt(worst2);
  sum.off_nominal_share /= count;
  return sum;
}

const std::vector<CellField>& cell_fields() {
  static const std::vector<CellField> fields{{"pose_m", &Cell::pose_m},
                                             {"x_m", &Cell::x_m},
                                             {"y_m", &Cell::y_m},
                                             {"z_m", &Cell::z_m},
                                             {"roll_deg", &Cell::roll_deg},
                                             {"pitch_deg", &Cell::pitch_deg},
                                             {"yaw_deg", &Cell::yaw_deg},
                                             {"tilt_deg", &Cell::tilt_deg},
                                             {"input_variation_deg_s", &Cell::input_variation_deg_s},
                                             {"worst_m", &Cell::worst_m},
                                             {"off_nominal_share", &Cell::off_nominal_share}};
  return fields;
}

Cell mean_of(const std::vector<Cell>& cells) {
  Cell mean;
  for (const CellField& field : cell_fields()) {
    for (const Cell& cell : cells) {
      mean.*field.member += cell.*field.member / static_cast<double>(cells.size());
    }
  }
  return mean;
}

Cell spread_of(const std::vector<Cell>& cells) {
  Cell spread;
  if (cells.size() < 2) {
    return spread;
  }
  const Cell mean = mean_of(cells);
  for (const CellField& field : cell_fields()) {
    for (const Cell& cell : cells) {
      spread.*field.member += square(cell.*field.member - mean.*field.member) / static_cast<double>(cells.size() - 1);
    }
    spread.*field.member = std::sqrt(spread.*field.member);
  }
  return spread;
}

Cell quantile_of(const std::vector<Cell>& cells, double share) {
  Cell out;
  for (const CellField& field : cell_fields()) {
    std::vector<double> values;
    for (const Cell& cell : cells) {
      values.push_back(cell.*field.member);
    }
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.empty() ? 0 : values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    if (below + 1 < values.size()) {
      out.*field.member = std::lerp(values[below], values[below + 1], place - static_cast<double>(below));
    } else if (!values.empty()) {
      out.*field.member = values.back();
    }
  }
  return out;
}

double time_optimal_rms_m(const std::vector<double>& steps_m, double tilt_rad, double window_s) {
  const double acceleration = model::acceleration_at_limit_m_s2(tilt_rad);
  double integral = 0.0;
  for (const double step_m : steps_m) {
    const double half_s = std::sqrt(std::abs(step_m) / acceleration);
    // Error in the first half: D (1 - s^2/2); in the second: D (1 - s)^2 / 2; s is the time in the half over half_s.
    integral += square(step_m) * half_s * ((1.0 - 1.0 / 3.0 + 1.0 / 20.0) + 1.0 / 20.0);
  }
  return std::sqrt(integral / window_s);
}

}  // namespace m100::lab::experiments
