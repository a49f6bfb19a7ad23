// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/axis/row_readings.h"

#include <algorithm>

#include "host_tests/lab/identify/axis/axis_remainder.h"
#include "host_tests/lab/identify/remainder/whitening.h"

namespace m100::lab::identify {

RowReadings readings_of(const AxisData& data, const std::vector<Range>& ranges) {
  RowReadings out;
  if (slow_rows(data)) {
    out.held = {held_between_rows(data, false), held_between_rows(data, true)};
  }
  out.runs.emplace_back(data, ranges);
  for (const AxisData& reading : out.held) {
    out.runs.emplace_back(reading, ranges);
  }
  return out;
}

void weigh_by_what_is_known(std::span<FreeRun> readings, const model::StickAxis& model) {
  const Rows error = readings.front().error(model);
  Rows unknown = Rows::Zero(error.size());
  for (const FreeRun& reading : readings) {
    unknown = unknown.cwiseMax((reading.error(model) - error).cwiseAbs());
  }
  const std::vector<Segment>& segments = readings.front().segments();
  const Ar filter = autoregression(error, segments);
  Rows white = error;
  whiten(filter, segments, white);
  const double power = white.squaredNorm() / std::max(1.0, whitened_rows(segments));
  // What is not known of a row is another thing in the next one: powers add.
  Rows doubt = unknown.array().square();
  whiten(-filter.cwiseAbs2(), segments, doubt);
  if (power > 0.0) {
    const Rows weights = (1.0 + doubt.array() / power).rsqrt();
    for (FreeRun& reading : readings) {
      reading.weigh(weights);
    }
  }
}

}  // namespace m100::lab::identify
