// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/translation_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "firmware/core/maths.h"
#include "host_tests/lab/identify/data/ground_time.h"
#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/identify/data/translation_data.h"

namespace m100::lab::identify::translation {
namespace {

using logs::FlightLog;
using logs::Signal;

/// One way to read a log's attitude.
struct AttitudeHypothesis {
  const char* what;
  const char* signal;
  const char* sentence;
  bool exchanged = false;
  double roll_sign = 1.0;
  double pitch_sign = 1.0;
  double yaw_sign = 1.0;
  double turn_rad = 0.0;
};

constexpr double kMinGain = 0.5;
constexpr double kMaxGain = 2.0;
constexpr double kQuarter = 0.5 * std::numbers::pi;
constexpr std::array<AttitudeHypothesis, 15> kReadings{{
    {"", "", "as the column map says"},
    {"sign_reversed", "attitude_roll", "roll with the other sign", false, -1.0, 1.0},
    {"sign_reversed", "attitude_pitch", "pitch with the other sign", false, 1.0, -1.0},
    {"sign_reversed", "attitude_roll", "roll and pitch with the other sign", false, -1.0, -1.0},
    {"swapped_axes", "attitude_roll", "roll and pitch exchanged", true, 1.0, 1.0},
    {"swapped_axes", "attitude_roll", "roll and pitch exchanged, roll with the other sign", true, -1.0, 1.0},
    {"swapped_axes", "attitude_roll", "roll and pitch exchanged, pitch with the other sign", true, 1.0, -1.0},
    {"swapped_axes", "attitude_roll", "roll and pitch exchanged, both with the other sign", true, -1.0, -1.0},
    {"sign_reversed", "attitude_yaw", "yaw with the other sign", false, 1.0, 1.0, -1.0},
    {"sign_reversed", "attitude_yaw", "yaw and roll with the other sign", false, -1.0, 1.0, -1.0},
    {"swapped_axes", "attitude_yaw", "the heading a quarter turn to the left", false, 1.0, 1.0, 1.0, kQuarter},
    {"swapped_axes", "attitude_yaw", "the heading a quarter turn to the right", false, 1.0, 1.0, 1.0, -kQuarter},
    {"swapped_axes", "attitude_yaw", "yaw with the other sign and a quarter turn", false, 1.0, 1.0, -1.0, kQuarter},
    // In a mirrored world the attitude is mirrored, too: roll and yaw change their signs.
    {"swapped_axes", "position", "north and east exchanged (ENU read as NED, or the reverse)", false, -1.0, 1.0, -1.0,
     -kQuarter},
    {"swapped_axes", "position", "x and y of the world exchanged", false, -1.0, 1.0, -1.0, kQuarter},
}};

/// How well an interpretation of the attitude fits.
struct ReadingFit {
  double gain = 0.0;           ///< of the acceleration on g times the tilt; 1 where the interpretation is right
  double rms = 0.0;            ///< of the residual
  std::vector<double> blocks;  ///< sum of the squared residual in each block
};

/// The residual of the horizontal acceleration under one interpretation of the attitude, after removing the means of
/// both axes and one common gain, limited to 0.5 to 2.
ReadingFit fit_of(const AttitudeHypothesis& hypothesis, const FlightLog& log, const TranslationData& data,
                  const TranslationBlocks& blocks, const std::vector<std::size_t>& samples) {
  std::array<std::vector<double>, 2> tilt;
  const auto& roll = log.of(Signal::kAttitudeRoll);
  const auto& pitch = log.of(Signal::kAttitudePitch);
  const auto& yaw = log.of(Signal::kAttitudeYaw);
  tilt.fill(std::vector<double>(log.size));
  for (std::size_t i = 0; i < log.size; ++i) {
    const double own_roll = hypothesis.roll_sign * (hypothesis.exchanged ? pitch[i] : roll[i]);
    const double own_pitch = hypothesis.pitch_sign * (hypothesis.exchanged ? roll[i] : pitch[i]);
    const double heading = hypothesis.yaw_sign * (yaw.empty() ? 0.0 : yaw[i]) + hypothesis.turn_rad;
    const double forward = std::sin(own_pitch) * std::cos(own_roll);
    tilt[0][i] = kStandardGravity_m_s2 * (forward * std::cos(heading) + std::sin(own_roll) * std::sin(heading));
    tilt[1][i] = kStandardGravity_m_s2 * (forward * std::sin(heading) - std::sin(own_roll) * std::cos(heading));
  }
  std::array<double, 2> mean_tilt{};
  std::array<double, 2> mean_measured{};
  std::array<std::vector<double>, 2> filtered;
  const double n = static_cast<double>(samples.size());
  for (std::size_t c = 0; c < 2; ++c) {
    for (const std::size_t i : samples) {
      filtered[c].push_back(data.filtered(tilt[c], i));
      mean_tilt[c] += filtered[c].back() / n;
      mean_measured[c] += data.measured[c][i] / n;
    }
  }
  double tt = 0.0;
  double tm = 0.0;
  double mm = 0.0;
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const double t = filtered[c][k] - mean_tilt[c];
      const double m = data.measured[c][samples[k]] - mean_measured[c];
      tt += t * t;
      tm += t * m;
      mm += m * m;
    }
  }
  ReadingFit out;
  out.gain = tt > 0.0 ? tm / tt : 0.0;
  const double fair = std::clamp(out.gain, kMinGain, kMaxGain);  // a sign must not be hidden by a negative gain
  out.rms = std::sqrt(std::max(0.0, mm - 2.0 * fair * tm + fair * fair * tt) / (2.0 * n));
  std::size_t k = 0;
  for (const TranslationBlocks::Block& block : blocks.blocks) {
    double square = 0.0;
    for (std::size_t i = 0; i < block.samples.size(); ++i, ++k) {
      for (std::size_t c = 0; c < 2; ++c) {
        const double left = data.measured[c][samples[k]] - mean_measured[c] - fair * (filtered[c][k] - mean_tilt[c]);
        square += left * left;
      }
    }
    out.blocks.push_back(square);
  }
  return out;
}

/// Whether `one` fits significantly better than `other`: by four standard errors of the paired difference over the
/// blocks, and with a plausible gain. Four standard errors are exceeded by chance in 2 of 100 logs (Student's t, ten
/// blocks, fourteen interpretations).
bool clearly_better(const ReadingFit& one, const ReadingFit& other) {
  constexpr std::size_t kMinBlocks = 8;
  constexpr double kErrors = 4.0;
  constexpr double kMaxShare = 0.85;  // of the other's RMS: a smaller improvement is no matter of signs or axes
  const std::size_t n = one.blocks.size();
  if (n < kMinBlocks || one.rms > kMaxShare * other.rms || one.gain < kMinGain || one.gain > kMaxGain) {
    return false;
  }
  double mean = 0.0;
  for (std::size_t b = 0; b < n; ++b) {
    mean += (other.blocks[b] - one.blocks[b]) / static_cast<double>(n);
  }
  double variance = 0.0;
  for (std::size_t b = 0; b < n; ++b) {
    const double off = other.blocks[b] - one.blocks[b] - mean;
    variance += off * off / static_cast<double>(n - 1);
  }
  return mean > kErrors * std::sqrt(variance / static_cast<double>(n));
}

/// The wanted samples without those in gaps.
std::vector<char> without_gaps(std::vector<char> wanted, const std::vector<std::uint8_t>& gap) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = wanted[i] != 0 && gap[i] == 0 ? 1 : 0;
  }
  return wanted;
}

/// Marks a sample of the signal as a gap.
void leave_out(Signal signal, std::size_t sample, FlightLog& log) {
  log.gap[sample] = 1;
  if (!log.signal_gap.empty()) {  // otherwise one gap list holds for all signals
    std::vector<std::uint8_t>& own = log.signal_gap[signal];
    own.resize(log.size, 0);
    own[sample] = 1;
  }
}

}  // namespace

FlightLog repaired(const FlightLog& log, const std::vector<Range>& requested, std::vector<Finding>& findings) {
  constexpr double kFilter_s = 0.3;  // more than the reach of the widest filter to either side
  FlightLog out = log;
  const std::vector<char> wanted = mask_ranges(log, requested, kFilter_s);
  const auto append = [&](std::vector<Finding> more) { findings.insert(findings.end(), more.begin(), more.end()); };
  for (const Signal signal :
       {Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kAttitudeYaw, Signal::kVelocityX, Signal::kVelocityY,
        Signal::kVelocityZ, Signal::kPositionX, Signal::kPositionY, Signal::kPositionZ}) {
    if (!out.has(signal)) {
      continue;
    }
    const std::string name(logs::name_of(signal));
    if (signal == Signal::kAttitudeRoll || signal == Signal::kAttitudePitch) {
      append(repair_units(out.of(signal), wanted, name));
    }
    const std::vector<std::uint8_t> gap = out.gap_of({signal});
    std::vector<char> used = without_gaps(wanted, gap);
    append(repair_samples(out.of(signal), used, {out.start_s, out.period_s, out.row_of(signal)}, name));
    for (std::size_t i = 0; i < out.size; ++i) {
      if (used[i] == 0 && wanted[i] != 0 && gap[i] == 0) {
        leave_out(signal, i, out);
      }
    }
  }
  append(ground_findings(ground_times(out)));
  return out;
}

std::vector<Finding> misread_attitude(const FlightLog& log, const std::vector<Range>& ranges) {
  constexpr double kMuchBetter = 0.5;
  constexpr double kAsGood = 1.1;
  if (!log.has(Signal::kAttitudeRoll) || !log.has(Signal::kAttitudePitch)) {
    return {};
  }
  const TranslationData data(log, ThrustSource::kWeight);
  const TranslationBlocks blocks(data, ranges);
  std::vector<std::size_t> samples;
  for (const TranslationBlocks::Block& block : blocks.blocks) {
    samples.insert(samples.end(), block.samples.begin(), block.samples.end());
  }
  if (samples.empty()) {
    return {};
  }
  std::array<ReadingFit, kReadings.size()> fits{};
  std::array<double, kReadings.size()> left{};
  for (std::size_t k = 0; k < kReadings.size(); ++k) {
    fits[k] = fit_of(kReadings[k], log, data, blocks, samples);
    left[k] = fits[k].rms;
  }
  const auto best = static_cast<std::size_t>(std::min_element(left.begin(), left.end()) - left.begin());
  std::vector<Finding> out;
  const double gain = fits[best].gain;
  if (left[best] > 0.0 && (gain > 0.7 * core::kRadian_deg || (gain > 0.0 && gain < 1.4 / core::kRadian_deg))) {
    out.push_back({.what = "wrong_unit",
                   .signal = data.source,
                   .text = data.source + " and attitude differ by a factor of " + std::to_string(gain) +
                           ": one of them is probably in degrees"});
  }
  if (best == 0 || (left[best] > kMuchBetter * left[0] && !clearly_better(fits[best], fits[0]))) {
    return out;
  }
  std::string text = std::string("the acceleration fits ") + kReadings[best].sentence;
  for (std::size_t k = 1; k < kReadings.size(); ++k) {
    text += k != best && left[k] < kAsGood * left[best] ? std::string(", or ") + kReadings[k].sentence : "";
  }
  out.push_back({.what = kReadings[best].what, .signal = kReadings[best].signal, .text = text});
  return out;
}

}  // namespace m100::lab::identify::translation
