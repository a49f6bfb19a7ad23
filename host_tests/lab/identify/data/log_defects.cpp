// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

namespace m100::lab::identify {
namespace {

using logs::FlightLog;

constexpr double kAfterTakeOff_s = 1.0;  // ground effect, motors still spinning up

std::size_t row_in_samples(const SampleGrid& clock) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(clock.row_s / clock.period_s)));
}

}  // namespace

void mask_unusable(const FlightLog& log, const std::vector<std::uint8_t>& gap,
                   const std::vector<std::pair<double, double>>& ground, double memory_s, std::vector<char>& valid) {
  const auto memory = static_cast<std::size_t>(std::lround(memory_s / log.period_s));
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < std::min(valid.size(), gap.size()); ++i) {
    unknown = gap[i] != 0 ? memory + 1 : unknown > 0 ? unknown - 1 : 0;
    valid[i] = unknown > 0 ? 0 : valid[i];
  }
  for (const auto& [from_s, to_s] : ground) {
    const std::size_t end = log.index_of(to_s + kAfterTakeOff_s);
    for (std::size_t i = log.index_of(from_s); i < std::min(end, valid.size()); ++i) {
      valid[i] = 0;
    }
  }
}

double hold_s(const std::vector<double>& values, const std::vector<char>& used, double period_s) {
  std::vector<double> runs;
  std::size_t since = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != values[i - 1] || used[i] == 0) {
      if (used[i] != 0) {
        runs.push_back(static_cast<double>(i - since));
      }
      since = i;
    }
  }
  return quantile(std::move(runs), 0.5) * period_s;
}

namespace {

/// Share of a stick's arrivals at its stops that come from more than a quarter of the travel away within one row. A
/// machine jumps there (pulses, steps); a hand whose log was clipped passes through the values in between.
double placed_share(const std::vector<double>& stick, const std::vector<char>& used, std::size_t row, double low,
                    double high) {
  const double slack = 0.005 * (high - low);
  const auto at_stop = [&](std::size_t i) { return stick[i] > high - slack || stick[i] < low + slack; };
  double arrivals = 0.0;
  double placed = 0.0;
  for (std::size_t i = row; i < stick.size(); ++i) {
    if (used[i] != 0 && used[i - row] != 0 && at_stop(i) && std::abs(stick[i] - stick[i - 1]) > slack) {
      arrivals += 1.0;
      placed += std::abs(stick[i] - stick[i - row]) > 0.25 * (high - low) ? 1.0 : 0.0;
    }
  }
  return arrivals > 0.0 ? placed / arrivals : 0.0;
}

}  // namespace

double clipped_share(const std::vector<double>& stick, const std::vector<char>& used, const SampleGrid& clock) {
  constexpr double kTellsHand_s =
      0.055;  // a hand does not cross a quarter of its travel in this time; slower rows hide this
  constexpr double kMajority = 0.5;
  double low = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < stick.size(); ++i) {
    low = used[i] != 0 ? std::min(low, stick[i]) : low;
    high = used[i] != 0 ? std::max(high, stick[i]) : high;
  }
  const double slack = 0.005 * (high - low);
  if (!(std::abs(high + low) < 4.0 * slack)) {
    return 0.0;
  }
  if (clock.row_s < kTellsHand_s && placed_share(stick, used, row_in_samples(clock), low, high) > kMajority) {
    return 0.0;
  }
  std::size_t at_stop = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < stick.size(); ++i) {
    count += used[i] != 0 ? 1U : 0U;
    at_stop += used[i] != 0 && (stick[i] > high - slack || stick[i] < low + slack) ? 1U : 0U;
  }
  return static_cast<double>(at_stop) / static_cast<double>(std::max<std::size_t>(1, count));
}

std::vector<char> mask_ranges(const FlightLog& log, const std::vector<std::pair<double, double>>& ranges,
                              double margin_s) {
  std::vector<char> out(log.size, ranges.empty() ? 1 : 0);
  for (const auto& [from_s, to_s] : ranges) {
    const std::size_t end = log.index_of(to_s + margin_s);
    for (std::size_t i = log.index_of(from_s - margin_s); i < end; ++i) {
      out[i] = 1;
    }
  }
  return out;
}

std::vector<Finding> repair_units(std::vector<double>& angle_rad, const std::vector<char>& used,
                                  const std::string& signal) {
  // A quantile instead of the maximum: one broken sample must not rescale a log.
  std::vector<double> sizes;
  for (std::size_t i = 0; i < angle_rad.size(); ++i) {
    if (used[i] != 0) {
      sizes.push_back(std::abs(angle_rad[i]));
    }
  }
  const double maximum = quantile(std::move(sizes), 0.995);
  if (!(maximum > 1.02 * std::numbers::pi)) {
    return {};
  }
  for (double& value : angle_rad) {
    value *= std::numbers::pi / 180.0;
  }
  return {
      {.what = "wrong_unit",
       .signal = signal,
       .text = signal + " goes to " + std::to_string(maximum) +
               ", more than half a turn: read as degrees (scale = 0.0174533 in the column map removes this finding)"}};
}

namespace {

struct Found {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t samples = 0;
  void add(std::size_t from, std::size_t to) {
    first = samples == 0 ? from : first;
    last = to;
    samples += to - from;
  }
};

/// The runs of equal used values, as samples [begin, end).
std::vector<std::pair<std::size_t, std::size_t>> equal_runs(const std::vector<double>& values,
                                                            const std::vector<char>& used) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= values.size(); ++i) {
    const bool goes_on = i < values.size() && used[i] != 0 && used[i - 1] != 0 && values[i] == values[i - 1];
    if (!goes_on) {
      if (used[i - 1] != 0) {
        out.emplace_back(begin, i);
      }
      begin = i;
    }
  }
  return out;
}

/// The smallest step of a quantised signal: the 1 % quantile of its non-zero steps.
double quantum_of(const std::vector<double>& values) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != values[i - 1]) {
      steps.push_back(std::abs(values[i] - values[i - 1]));
    }
  }
  return quantile(std::move(steps), 0.01);
}

/// Whether a moving signal stops at `begin` from one row to the next: a signal that comes to rest has smaller and
/// smaller steps before.
bool stops_at_once(const std::vector<double>& values, std::size_t begin, double usual) {
  constexpr std::size_t kBefore = 3;
  double step = 0.0;
  for (std::size_t i = begin > kBefore ? begin - kBefore : 1; i <= begin && i > 0; ++i) {
    step = std::max(step, std::abs(values[i] - values[i - 1]));
  }
  return begin > 0 && step > 0.5 * usual;
}

/// Removes frozen samples from `used`. @param row  samples between the rows in which the signal was logged
Found remove_frozen(const std::vector<double>& values, std::vector<char>& used, std::size_t row) {
  constexpr double kMinRows = 5.0;
  constexpr double kCadences = 4.0;
  constexpr double kFewRepeats = 20.0;  // more repeats than a log has freezes
  constexpr double kJump = 3.0;         // of the usual step from row to row
  constexpr double kOrdinary = 0.99;    // of all steps from row to row
  constexpr double kNever = 10.0;       // times as long as nearly all other runs: unusual for this signal
  constexpr double kFineSteps = 3.0;    // of the smallest step; a coarsely quantised signal often repeats its value
  const auto runs = equal_runs(values, used);
  std::vector<double> lengths;
  std::vector<double> steps;
  for (const auto& [begin, end] : runs) {
    lengths.push_back(static_cast<double>(end - begin));
    if (end < values.size() && used[end] != 0) {
      steps.push_back(std::abs(values[end] - values[begin]));
    }
  }
  const double unheard = kNever * quantile(lengths, 0.99);
  // A rounded signal often repeats its value: where there are enough repeats, a run is compared with them.
  std::vector<double> repeats;
  std::copy_if(lengths.begin(), lengths.end(), std::back_inserter(repeats), [](double length) { return length > 1.0; });
  const bool rounded = static_cast<double>(repeats.size()) > kFewRepeats;
  const double minimum =
      std::max(kMinRows * static_cast<double>(row), kCadences * quantile(std::move(rounded ? repeats : lengths), 0.9));
  const double usual = quantile(steps, 0.5);
  const bool fine = usual > kFineSteps * quantum_of(values);
  // A quantised signal rests on one level and continues from there: only a step larger than its usual steps is a jump.
  const double leap = fine ? kJump * usual : quantile(std::move(steps), kOrdinary);
  Found out;
  for (const auto& [begin, end] : runs) {
    const bool jumps = end < values.size() && used[end] != 0 && std::abs(values[end] - values[begin]) > leap;
    const auto length = static_cast<double>(end - begin);
    const bool alien = fine && length > unheard && stops_at_once(values, begin, usual);
    if (length > minimum && (jumps || alien)) {
      std::fill(used.begin() + static_cast<std::ptrdiff_t>(begin), used.begin() + static_cast<std::ptrdiff_t>(end),
                static_cast<char>(0));
      out.add(begin, end);
    }
  }
  return out;
}

/// Standard deviation of a signal's white noise: from second differences between its own rows, divided by root six.
double sigma_of(const std::vector<double>& values, const std::vector<char>& used, std::size_t row) {
  std::vector<double> bends;
  for (std::size_t i = 2 * row; i < values.size(); ++i) {
    if (used[i] != 0 && used[i - row] != 0 && used[i - 2 * row] != 0) {
      bends.push_back(std::abs(values[i] - 2.0 * values[i - row] + values[i - 2 * row]));
    }
  }
  // A log that was resampled by straight lines bends at its own rows only: then the upper tenth is the better estimate.
  return std::max(1.4826 * quantile(bends, 0.5), quantile(bends, 0.9) / 1.645) / std::sqrt(6.0);
}

/// Replaces outliers by the median of five rows. @param row  samples between the rows in which the signal was logged
/// @param minimum  distance from all predictions by its neighbours, beyond which a value is an outlier
/// @param back  whether the neighbours must agree with each other, to a quarter of the jump
Found replace_outliers(std::vector<double>& values, const std::vector<char>& used, std::size_t row, double minimum,
                       bool back) {
  Found out;
  const std::vector<double> old = values;
  for (std::size_t i = 2 * row; i + 2 * row < values.size(); ++i) {
    std::array<double, 5> five{old[i - 2 * row], old[i - row], old[i], old[i + row], old[i + 2 * row]};
    std::nth_element(five.begin(), five.begin() + 2, five.end());
    // A sharp turn is predicted by a straight line from one of its sides.
    const double from_left = std::abs(old[i] - (2.0 * old[i - row] - old[i - 2 * row]));
    const double from_right = std::abs(old[i] - (2.0 * old[i + row] - old[i + 2 * row]));
    // A smooth bend, which slow rows make sharp, is predicted by the cubic through its four neighbours.
    const double bend = (4.0 * (old[i - row] + old[i + row]) - old[i - 2 * row] - old[i + 2 * row]) / 6.0;
    double off = std::min({std::abs(old[i] - five[2]), from_left, from_right, std::abs(old[i] - bend)});
    if (back) {  // even the sharpest turn of a hand has a neighbour near it; a spoilt row has none
      off = std::min({off, std::abs(old[i] - old[i - row]), std::abs(old[i] - old[i + row])});
    }
    const bool returns = !back || std::abs(old[i + row] - old[i - row]) < 0.25 * off;
    if (used[i] != 0 && off > minimum && returns) {
      values[i] = five[2];
      out.add(i, i + 1);
    }
  }
  return out;
}

std::vector<Finding> sentence_of(const Found& found, const SampleGrid& clock, const char* what,
                                 const std::string& signal, const char* text) {
  if (found.samples == 0) {
    return {};
  }
  return {{.what = what,
           .signal = signal,
           .from_s = clock.start_s + clock.period_s * static_cast<double>(found.first),
           .to_s = clock.start_s + clock.period_s * static_cast<double>(found.last),
           .text = std::to_string(found.samples) + " samples of " + signal + text}};
}

constexpr double kSigmas = 12.0;
constexpr double kOutlierShare = 0.05;  // of the signal's large values; smaller outliers do no harm

}  // namespace

std::vector<Finding> repair_samples(std::vector<double>& values, std::vector<char>& used, const SampleGrid& clock,
                                    const std::string& signal) {
  std::vector<Finding> out = sentence_of(remove_frozen(values, used, row_in_samples(clock)), clock, "frozen", signal,
                                         " repeat the sample before them: excluded");
  const std::size_t row = row_in_samples(clock);
  const double sigma = sigma_of(values, used, row);
  if (sigma > 0.0) {
    const double minimum = std::max(kSigmas * sigma, kOutlierShare * large(values));
    const std::vector<Finding> more =
        sentence_of(replace_outliers(values, used, row, minimum, false), clock, "outliers", signal,
                    " jump away and back: replaced by the local median");
    out.insert(out.end(), more.begin(), more.end());
  }
  return out;
}

std::vector<Finding> repair_stick(std::vector<double>& values, const std::vector<char>& used, const SampleGrid& clock,
                                  const std::string& signal) {
  constexpr double kThereAndBack_s = 0.1;
  const std::size_t row = row_in_samples(clock);
  if (2.0 * static_cast<double>(row) * clock.period_s > 1.01 * kThereAndBack_s) {
    return {};
  }
  const double rounding = quantum_of(values) / std::sqrt(12.0);
  const double minimum =
      std::max(kSigmas * std::max(sigma_of(values, used, row), rounding), kOutlierShare * large(values));
  return sentence_of(replace_outliers(values, used, row, minimum, true), clock, "outliers", signal,
                     " jump away and back faster than a hand can: replaced by the local median");
}

double share_explained(const std::vector<double>& stick, const std::vector<double>& response,
                       const std::vector<char>& used, double period_s) {
  constexpr double kLongest_s = 0.6;
  const auto longest = static_cast<std::size_t>(std::lround(kLongest_s / period_s));
  const std::size_t step = std::max<std::size_t>(1, longest / 12);
  double best = 0.0;
  for (std::size_t lag = 0; lag <= longest; lag += step) {
    double uu = 0.0;
    double yy = 0.0;
    double uy = 0.0;
    for (std::size_t i = lag; i < response.size(); ++i) {
      if (used[i] != 0) {
        uu += stick[i - lag] * stick[i - lag];
        yy += response[i] * response[i];
        uy += stick[i - lag] * response[i];
      }
    }
    best = std::max(best, uu > 0.0 && yy > 0.0 ? uy * uy / (uu * yy) : 0.0);
  }
  return best;
}

}  // namespace m100::lab::identify
