// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "host_tests/lab/identify/model/axis/axis_regressors.h"
#include "host_tests/lab/identify/residual_tests/predictable_share.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"

namespace m100::lab::identify {
namespace {

constexpr double kSettle_s = 1.0;  // a free run forgets its start within this time

/// Number of the flight in which a sample lies, from 1; 0 in a log that was not joined.
std::size_t flight_of(const AxisData& data, std::size_t sample) {
  return static_cast<std::size_t>(
      std::count_if(data.flights.begin(), data.flights.end(), [&](std::size_t begin) { return begin <= sample; }));
}

/// Divides a run of `samples` samples, in blocks of `length`, into the means that the residual test works with.
Thinned thin_run(double period_s, std::size_t length, std::size_t samples) {
  ResidualInput run;
  run.sample_period_s = period_s;
  for (std::size_t at = 0; at < samples; at += length) {
    run.block_begin.push_back(at);
  }
  return thin(run, samples);
}

/// Samples of a free run that has forgotten its start.
struct SettledRun {
  std::size_t begin;
  std::size_t end;
  std::span<const double> error;
  std::span<const double> input_uncertainty;  ///< part of the error that the unknown stick between rows may cause
};

/// Appends the samples of a free run to the input, with their regressors.
void append(const AxisDataSet& part, std::optional<std::size_t> first_flight, const SettledRun& run,
            ResidualInput& input) {
  const AxisData& data = part.signals.data;
  const auto length = static_cast<std::size_t>(std::lround(AxisBlocks::kBlock_s / data.period_s));
  std::vector<double>& residual = input.residuals[0];
  for (std::vector<double>* each : {&residual, &input.time_s}) {
    each->reserve(each->size() + run.end - run.begin);  // a growing vector would take up to twice its size
  }
  for (std::size_t i = run.begin; i < run.end; ++i) {
    if ((i - run.begin) % length == 0) {
      input.block_begin.push_back(residual.size() + i - run.begin);
    }
    input.time_s.push_back(data.time_s(i));
    if (first_flight) {
      input.flight.push_back(*first_flight + flight_of(data, i));
    }
  }
  residual.insert(residual.end(), run.error.begin(), run.error.end());
  const Thinned rows = thin_run(data.period_s, length, run.end - run.begin);
  const Eigen::VectorXd input_uncertainty = mean_of(run.input_uncertainty, rows);
  input.input_uncertainty.insert(input.input_uncertainty.end(), input_uncertainty.begin(), input_uncertainty.end());
  merge(input.groups, axis_regressors(part.log, part.signals, run.begin, run.end, rows));
  merge(input.activity, axis_activity(part.signals, run.begin, run.end, rows));
}

/// Appends the final residual as one free run per range (from gap to gap), with its regressors.
/// @param first_flight  number of the log's first flight, so that two logs share no number; none: all is one flight
void append_free_run(const AxisDataSet& part, const model::StickAxis& model, std::optional<std::size_t> first_flight,
                     ResidualInput& input) {
  const AxisData& data = part.signals.data;
  const auto settling = static_cast<std::size_t>(std::lround(kSettle_s / data.period_s));
  const auto length = static_cast<std::size_t>(std::lround(AxisBlocks::kBlock_s / data.period_s));
  for (const Range& range : part.ranges) {
    const Range run{std::max(range.first - kSettle_s, data.start_s), range.second};
    const double whole_s = range.second - range.first + 2.0 * kSettle_s;
    const std::vector<double> input_uncertainty = intersample_error(data, {run}, model, whole_s);
    const AxisBlocks whole(data, {run}, whole_s);
    std::vector<double> error(whole.samples());
    whole.error(model, {}, error);
    whole.release_buffers();
    std::size_t from = 0;
    for (std::size_t number = 0; number < whole.size(); ++number) {
      const AxisBlocks::Block& block = whole[number];
      const std::size_t samples = block.end - block.begin;
      if (samples >= settling + length / 2) {  // otherwise too short after settling
        const auto settled = [&](const std::vector<double>& values) {
          return std::span(values).subspan(from + settling, samples - settling);
        };
        append(part, first_flight, {block.begin + settling, block.end, settled(error), settled(input_uncertainty)},
               input);
      }
      from += samples;
    }
  }
}

}  // namespace

std::vector<double> intersample_error(const AxisData& data, const std::vector<Range>& ranges,
                                      const model::StickAxis& model, double block_s) {
  const std::vector<double> line = AxisBlocks(data, ranges, block_s).response(model);
  std::vector<double> out(line.size(), 0.0);
  if (!is_stick_undersampled(data)) {
    AxisData earlier = data;
    std::copy(data.stick.begin() + 1, data.stick.end(), earlier.stick.begin());
    const std::vector<double> other = AxisBlocks(earlier, ranges, block_s).response(model);
    const double half_row = 0.5 * data.logged_stick_row_s() / data.period_s;
    for (std::size_t i = 0; i < std::min(out.size(), other.size()); ++i) {
      out[i] = half_row * std::abs(other[i] - line[i]);
    }
    return out;
  }
  for (const bool next : {false, true}) {
    const AxisData held = hold_between_rows(data, next);
    const std::vector<double> other = AxisBlocks(held, ranges, block_s).response(model);
    for (std::size_t i = 0; i < std::min(out.size(), other.size()); ++i) {
      out[i] = std::max(out[i], std::abs(other[i] - line[i]));
    }
  }
  return out;
}

AxisData hold_between_rows(AxisData data, bool next) {
  const auto row = static_cast<std::size_t>(std::lround(data.stick_row_s / data.period_s));
  const std::vector<double> line = data.stick;
  if (row < 2) {
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      const bool is_between = (line[i] - line[i - 1]) * (line[i + 1] - line[i]) > 0.0;
      data.stick[i] = is_between ? line[next ? i + 1 : i - 1] : line[i];
    }
    return data;
  }
  for (std::size_t i = 0; i < line.size(); ++i) {
    data.stick[i] = line[std::min((i / row + (next ? 1 : 0)) * row, line.size() - 1)];
  }
  return data;
}

model::StickAxis fitted_to(const AxisDataSet& part, const std::vector<Range>& ranges, const AxisFamily& family,
                           const Fit& fit) {
  const AxisDataSet all(part, ranges);
  const AxisFamily own(all.blocks);
  const Fit start = own.with_parameters_of(fit, family.model(fit));
  return own.model(own.fit(fit.structure, std::vector<int>(own.block_count(), 1), &start));
}

AxisSignals without_trims(AxisSignals signals, const std::vector<double>& trims) {
  AxisData& data = signals.data;
  for (std::size_t k = 0; k < std::min(trims.size(), data.flights.size()); ++k) {
    const std::size_t end = k + 1 < data.flights.size() ? data.flights[k + 1] : data.stick.size();
    for (std::size_t i = data.flights[k]; i < end; ++i) {
      data.stick[i] -= trims[k];
    }
  }
  return signals;
}

std::vector<std::string> residual_findings(const Request& request, const AxisDataSet& training,
                                           const AxisDataSet& validation, const model::StickAxis& model) {
  ResidualInput input;
  input.sample_period_s = training.signals.data.period_s;
  input.row_s = std::max(training.signals.data.row_s, training.signals.data.stick_row_s);
  input.residuals.resize(1);
  input.noise_floor = request.noise_floor;
  const std::vector<std::size_t>& flights = training.signals.data.flights;
  const bool one_log = &validation.log == &training.log;
  if (one_log && flights.size() <= 1) {
    append_free_run(training, model, std::nullopt, input);
    append_free_run(validation, model, std::nullopt, input);
  } else {
    append_free_run(training, model, 0, input);
    append_free_run(validation, model, one_log ? 0 : flights.size() + 1, input);
  }
  return test_residual(input, ResidualOptions{}).unexplained;
}

double noise_floor_at_rest(const AxisDataSet& part, const model::StickAxis& model, double minimum_counts) {
  const auto rest = static_cast<std::size_t>(std::lround(1.0 / part.signals.data.period_s));
  const auto& stick = part.signals.data.stick;
  const auto rested = [&](std::size_t i) {
    bool all = true;
    for (std::size_t k = i - rest; k <= i && all; k += 5) {
      all = std::abs(stick[k] - stick[i]) < 3.0 * minimum_counts;
    }
    return all;
  };
  std::vector<double> error(part.blocks.samples());
  part.blocks.error(model, {}, error);
  double sum = 0.0;
  std::size_t count = 0;
  std::size_t at = 0;
  for (std::size_t block = 0; block < part.blocks.size(); ++block) {
    for (std::size_t i = part.blocks[block].begin; i < part.blocks[block].end; ++i, ++at) {
      if (i < rest || i < part.blocks[block].begin + rest / 2) {
        continue;
      }
      if (rested(i)) {
        sum += error[at] * error[at];
        ++count;
      }
    }
  }
  return count > 2 * rest ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

}  // namespace m100::lab::identify
