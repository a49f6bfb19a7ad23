// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/translation_data_set.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/identify/model/translation/translation_family.h"

namespace m100::lab::identify::translation {

using logs::Signal;

TranslationDataSet::TranslationDataSet(const logs::FlightLog& of, const std::vector<Range>& ranges, ThrustSource thrust,
                                       FlightWindSource winds)
    : log(of), data(of, thrust), blocks(data, ranges, winds.head_s), measured(TranslationFamily::measured(blocks)) {
  data.winds_per_flight = winds.own;
}

double TranslationDataSet::rmse(const std::vector<double>& predicted) const {
  double sum = 0.0;
  for (std::size_t row = 0; row < measured.size(); ++row) {
    sum += (measured[row] - predicted[row]) * (measured[row] - predicted[row]);
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, measured.size())));
}

std::vector<double> TranslationDataSet::axis(const std::vector<double>& rows, std::size_t c) const {
  std::vector<double> out;
  for (const auto& block : blocks.blocks) {
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(block.row + c * block.samples.size());
    out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(block.samples.size()));
  }
  return out;
}

double TranslationDataSet::fit_percent(const std::vector<double>& predicted) const {
  double error = 0.0;
  double spread = 0.0;
  for (std::size_t c = 0; c < data.axes; ++c) {
    const std::vector<double> y = axis(measured, c);
    const std::vector<double> p = axis(predicted, c);
    double mean = 0.0;
    for (const double v : y) {
      mean += v / static_cast<double>(y.size());
    }
    for (std::size_t k = 0; k < y.size(); ++k) {
      error += (y[k] - p[k]) * (y[k] - p[k]);
      spread += (y[k] - mean) * (y[k] - mean);
    }
  }
  return spread > 0.0 ? 100.0 * (1.0 - std::sqrt(error / spread)) : 0.0;
}

HorizonErrors TranslationDataSet::horizon_rmse(const std::vector<double>& predicted) const {
  const auto mean_error = [&](std::size_t from, std::size_t length) {
    double error = 0.0;
    for (std::size_t j = from; j < from + length; ++j) {
      error += (measured[j] - predicted[j]) / static_cast<double>(length);
    }
    return error;
  };
  HorizonErrors out{};
  for (std::size_t horizon = 0; horizon < out.size(); ++horizon) {
    const auto length = static_cast<std::size_t>(std::lround(kHorizons_s[horizon] / blocks.sample_period_s));
    double sum = 0.0;
    std::size_t count = 0;
    for (const auto& block : blocks.blocks) {
      for (std::size_t c = 0; c < data.axes; ++c) {
        const std::size_t row = block.row + c * block.samples.size();
        for (std::size_t k = 0; k + length <= block.samples.size(); k += 3) {
          const double error = mean_error(row + k, length);
          sum += error * error;
          ++count;
        }
      }
    }
    out[horizon] = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
  }
  return out;
}

bool both_have(const Request& request, Signal signal) {
  return request.log->has(signal) && (request.validation_log == nullptr || request.validation_log->has(signal));
}

ThrustSource thrust_source(const Request& request) {
  if (both_have(request, Signal::kThrustRatio)) {
    return ThrustSource::kSetPoint;
  }
  std::vector<ThrustSource> rivals{ThrustSource::kWeight};
  if (request.log->has(Signal::kAttitudeRoll) && request.log->has(Signal::kAttitudePitch)) {
    rivals.push_back(ThrustSource::kTangents);
  }
  ThrustSource present = ThrustSource::kVertical;
  for (const ThrustSource rival : rivals) {
    const TranslationData before(*request.log, present);
    const TranslationData after(*request.log, rival);
    const double preference = TranslationFamily::preference(TranslationBlocks(before, request.train),
                                                            TranslationBlocks(after, request.train));
    present = preference > 0.5 ? rival : present;
  }
  return present;
}

}  // namespace m100::lab::identify::translation
