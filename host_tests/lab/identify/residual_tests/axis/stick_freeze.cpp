// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/stick_freeze.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace m100::lab::identify {
namespace {

constexpr double kHeld_s = 0.4;
constexpr double kAfter_s = 0.6;  // until the response follows the stick again
constexpr double kDenser = 10.0;
constexpr double kMinPower = 0.4;
constexpr double kMinTime = 0.5;    // outside of all holds
constexpr double kMinHolds = 0.25;  // of all held time: a few errors of a hand that often rests are no freeze
constexpr double kGrain = 1e-6;     // of its large values; a smaller difference is rounding

struct Hold {
  std::size_t begin;
  std::size_t end;  ///< sample that has another value
};

std::size_t row_of(const AxisData& data) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(data.stick_row_s / data.period_s)));
}

/// The median step of a moving stick from one row to the next.
double usual_step(const AxisData& data) {
  std::vector<double> steps;
  const std::size_t row = row_of(data);
  for (std::size_t i = row; i < data.stick.size(); i += row) {
    const double step = std::abs(data.stick[i] - data.stick[i - row]);
    if (step > kGrain * std::abs(data.stick[i])) {
      steps.push_back(step);
    }
  }
  return steps.empty() ? 0.0 : quantile(std::move(steps), 0.5);
}

/// Holds of a value that occurs in no other hold and that end in a jump, in time order.
std::vector<Hold> unique_holds(const AxisData& data) {
  const auto minimum = static_cast<std::size_t>(std::lround(kHeld_s / data.period_s));
  // Interpolation between two equal rows changes the value by rounding only.
  const double grain = kGrain * std::max(1e-9, large(data.stick));
  const auto grains = [&](std::size_t at) { return std::llround(data.stick[at] / grain); };
  std::vector<Hold> holds;
  std::map<long long, int> times;
  for (std::size_t begin = 0; begin < data.stick.size();) {
    std::size_t end = begin;
    while (end < data.stick.size() && std::abs(data.stick[end] - data.stick[begin]) < grain) {
      ++end;
    }
    if (end - begin >= minimum) {
      holds.push_back({begin, end});
      ++times[grains(begin)];
    }
    begin = end;
  }
  const double usual = usual_step(data);
  std::erase_if(holds, [&](const Hold& hold) {
    const std::size_t next = hold.end + row_of(data) - 1;
    return times[grains(hold.begin)] > 1 || hold.begin == 0 || next >= data.stick.size() ||
           std::abs(data.stick[next] - data.stick[hold.begin]) < usual;
  });
  return holds;
}

/// Squared error of some samples.
struct Power {
  double sum = 0.0;
  double samples = 0.0;

  void add(double error) {
    sum += error * error;
    samples += 1.0;
  }
  bool denser_than(const Power& other) const { return sum * other.samples > kDenser * other.sum * samples; }
};

struct HeldPower {
  Hold hold{0, 0};
  Power power{};
};

/// Adds the squared errors in each hold and just after it to `held`, and those outside of all holds to `outside`.
void add(const AxisDataSet& part, const model::StickAxis& model, std::vector<HeldPower>& held, Power& outside) {
  const AxisData& data = part.signals.data;
  std::vector<double> error(part.blocks.samples());
  part.blocks.error(model, {}, error);
  const std::vector<Hold> holds = unique_holds(data);
  const auto after = static_cast<std::size_t>(std::lround(kAfter_s / data.period_s));
  const std::size_t first = held.size();
  std::transform(holds.begin(), holds.end(), std::back_inserter(held), [](const Hold& one) { return HeldPower{one}; });
  std::size_t row = 0;
  for (std::size_t block = 0; block < part.blocks.size(); ++block) {
    for (std::size_t i = part.blocks[block].begin; i < part.blocks[block].end; ++i, ++row) {
      const auto next =
          static_cast<std::size_t>(std::upper_bound(holds.begin(), holds.end(), i,
                                                    [](std::size_t at, const Hold& one) { return at < one.begin; }) -
                                   holds.begin());
      const bool inside = next > 0 && i < holds[next - 1].end + after;
      (inside ? held[first + next - 1].power : outside).add(error[row]);
    }
  }
}

}  // namespace

std::vector<int> weights_beside_suspect(const AxisDataSet& training, const model::StickAxis& model) {
  const auto after = static_cast<std::size_t>(std::lround(kAfter_s / training.signals.data.period_s));
  std::vector<int> weights(training.blocks.size(), 1);
  std::vector<HeldPower> held;
  Power outside;
  add(training, model, held, outside);
  const auto suspect = std::max_element(
      held.begin(), held.end(), [](const HeldPower& a, const HeldPower& b) { return a.power.sum < b.power.sum; });
  for (std::size_t block = 0; block < weights.size() && suspect != held.end(); ++block) {
    const bool overlaps =
        suspect->hold.begin < training.blocks[block].end && training.blocks[block].begin < suspect->hold.end + after;
    weights[block] = overlaps ? 0 : 1;
  }
  const auto kept = static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 1));
  return 2 * kept < weights.size() ? std::vector<int>(weights.size(), 1) : weights;
}

std::vector<Finding> stick_freeze(const std::vector<const AxisDataSet*>& parts, const model::StickAxis& model) {
  std::vector<HeldPower> held;
  Power outside;
  for (const AxisDataSet* part : parts) {
    add(*part, model, held, outside);
  }
  Power all = outside;
  Power frozen;
  double held_samples = 0.0;
  std::size_t longest = 0;
  for (const HeldPower& one : held) {
    all.sum += one.power.sum;
    all.samples += one.power.samples;
    held_samples += one.power.samples;
    if (one.power.denser_than(outside)) {
      frozen.sum += one.power.sum;
      frozen.samples += one.power.samples;
      longest = std::max(longest, one.hold.end - one.hold.begin);
    }
  }
  if (outside.samples < kMinTime * all.samples || frozen.sum < kMinPower * all.sum ||
      frozen.samples < kMinHolds * held_samples || longest == 0) {
    return {};
  }
  const AxisSignals& signals = parts.front()->signals;
  const std::string text = printed(
      "%s holds one value for up to %.1f s while %s keeps moving; %.0f %% of the residual power lies there: "
      "the column may be frozen",
      signals.stick_name.c_str(), static_cast<double>(longest) * signals.data.period_s, signals.response_name.c_str(),
      100.0 * frozen.sum / all.sum);
  return {{.what = "frozen", .signal = signals.stick_name, .text = text}};
}

}  // namespace m100::lab::identify
