// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/axis/axis_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "firmware/core/eigen.h"
#include "firmware/sysid/axis_dynamics.h"

namespace m100::lab::identify {
namespace {

constexpr std::size_t kHalfWindow = AxisBlocks::kStartSamples / 2;

// Value and slope at `at` of the least-squares quadratic through up to eleven valid samples around it; with fewer than
// four of them, the measured value and slope 0.
std::pair<double, double> measured_state(const AxisData& data, std::size_t at) {
  const std::size_t first = at > kHalfWindow ? at - kHalfWindow : 0;
  const std::size_t last = std::min(data.measured.size() - 1, at + kHalfWindow);
  core::Matrix<double, 3, 3> normal = core::Matrix<double, 3, 3>::Zero();
  core::Vector<double, 3> right = core::Vector<double, 3>::Zero();
  for (std::size_t i = first; i <= last; ++i) {
    if (data.valid[i]) {
      const double x = static_cast<double>(i) - static_cast<double>(at);
      const core::Vector<double, 3> powers(1.0, x, x * x);
      normal += powers * powers.transpose();
      right += powers * data.measured[i];
    }
  }
  constexpr double kEnough = 4.0;
  if (normal(0, 0) < kEnough) {
    return {data.measured[at], 0.0};
  }
  const core::Vector<double, 3> fitted = normal.ldlt().solve(right);
  return {fitted(0), fitted(1) / data.period_s};
}

using Dynamics = sysid::AxisDynamics<double>;

constexpr std::size_t kLanes = AxisBlocks::kLanes;

/// Simulates kLanes vehicles in turn, sample by sample, and replaces the commands of each by its response. This is
/// faster than one after the other, because the processor computes one vehicle while it waits for another's product.
void respond(std::array<Dynamics, kLanes> dynamics, std::span<double> driven, std::size_t samples) {
  for (std::size_t i = 0; i < samples; ++i) {
    for (std::size_t vehicle = 0; vehicle < kLanes; ++vehicle) {
      double& at = driven[vehicle * samples + i];
      const double command = at;
      at = dynamics[vehicle].value();
      dynamics[vehicle].step(command);
    }
  }
}

}  // namespace

AxisBlocks::AxisBlocks(const AxisData& data, const std::vector<Range>& ranges, double block_s) : data_(&data) {
  const std::size_t count = data.measured.size();
  const auto sample_of = [&](double t_s) {
    const double at = std::ceil((t_s - data.start_s) / data.period_s - 1e-6);
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count)));
  };
  const auto length = static_cast<std::size_t>(std::lround(block_s / data.period_s));
  const auto past = static_cast<std::size_t>(std::lround(kPast_s / data.period_s));
  const std::size_t minimum = std::min(length, static_cast<std::size_t>(std::lround(kBlock_s / data.period_s)));
  for (const Range& range : ranges) {
    const std::size_t begin = sample_of(range.first);
    const std::size_t end = sample_of(range.second);
    if (end <= begin) {
      continue;
    }
    commands_.add({begin > past ? begin - past : 0, begin, end});
    for (std::size_t at = begin; at < end;) {
      if (!data.valid[at]) {
        ++at;  // no measured state to start from
        continue;
      }
      const auto from = data.valid.begin() + static_cast<std::ptrdiff_t>(at);
      const auto to = data.valid.begin() + static_cast<std::ptrdiff_t>(std::min(at + length, end));
      const std::size_t stop = at + static_cast<std::size_t>(std::find(from, to, 0) - from);
      if (2 * (stop - at) >= minimum) {
        const auto [value, rate_per_s] = measured_state(data, at);
        blocks_.push_back({at, stop, value, rate_per_s, commands_.size() - 1});
        samples_ += stop - at;
      }
      at = stop;
    }
  }
}

std::size_t AxisBlocks::run(const model::StickAxis& axis, std::span<const Block* const> blocks,
                            std::span<double> out) const {
  std::size_t longest = 0;
  for (const Block* block : blocks) {
    longest = std::max(longest, block->end - block->begin);
  }
  driven_.assign(kLanes * longest, 0.0);
  const Dynamics still(axis, data_->period_s);
  std::array<Dynamics, kLanes> dynamics{still, still, still, still};
  for (std::size_t lane = 0; lane < blocks.size(); ++lane) {
    const Block& block = *blocks[lane];
    arrived_commands(commands_.of(*data_, axis, block.stretch), axis, data_->period_s,
                     block.begin - commands_[block.stretch].past,
                     std::span<double>(driven_).subspan(lane * longest, block.end - block.begin));
    dynamics[lane].start(blocks[lane]->value, blocks[lane]->rate_per_s);
  }
  respond(dynamics, driven_, longest);
  auto to = out.begin();
  for (std::size_t lane = 0; lane < blocks.size(); ++lane) {
    const auto from = driven_.begin() + static_cast<std::ptrdiff_t>(lane * longest);
    to = std::copy_n(from, blocks[lane]->end - blocks[lane]->begin, to);
  }
  return static_cast<std::size_t>(to - out.begin());
}

std::size_t AxisBlocks::simulate(const model::StickAxis& axis, std::span<const int> weights,
                                 std::span<double> out) const {
  std::vector<const Block*> used;
  for (std::size_t number = 0; number < blocks_.size(); ++number) {
    if (weights.empty() || weights[number] > 0) {
      used.push_back(&blocks_[number]);
    }
  }
  std::size_t count = 0;
  for (std::size_t at = 0; at < used.size(); at += kLanes) {
    count += run(axis, std::span(used).subspan(at, std::min(kLanes, used.size() - at)), out.subspan(count));
  }
  return count;
}

std::size_t AxisBlocks::error(const model::StickAxis& axis, std::span<const int> weights, std::span<double> out) const {
  const std::size_t count = simulate(axis, weights, out);
  std::size_t at = 0;
  for (std::size_t number = 0; number < blocks_.size(); ++number) {
    const int weight = weights.empty() ? 1 : weights[number];
    if (weight <= 0) {
      continue;
    }
    const double scale = weight == 1 ? 1.0 : std::sqrt(static_cast<double>(weight));
    for (std::size_t i = blocks_[number].begin; i < blocks_[number].end; ++i, ++at) {
      out[at] = data_->valid[i] ? scale * (out[at] - data_->measured[i]) : 0.0;
    }
  }
  return count;
}

std::vector<double> AxisBlocks::response(const model::StickAxis& axis) const {
  std::vector<double> out(samples_);
  simulate(axis, {}, out);
  return out;
}

double AxisBlocks::rmse(const model::StickAxis& axis) const {
  std::vector<double> out(samples_);
  error(axis, {}, out);
  const double sum = std::inner_product(out.begin(), out.end(), out.begin(), 0.0);
  return samples_ > 0 ? std::sqrt(sum / static_cast<double>(samples_)) : 0.0;
}

double AxisBlocks::fit_percent(const model::StickAxis& axis) const {
  std::vector<double> measured;
  for (const Block& block : blocks_) {
    const auto from = data_->measured.begin() + static_cast<std::ptrdiff_t>(block.begin);
    measured.insert(measured.end(), from, from + static_cast<std::ptrdiff_t>(block.end - block.begin));
  }
  const double mean = std::accumulate(measured.begin(), measured.end(), 0.0) / static_cast<double>(samples_);
  const double spread = std::accumulate(measured.begin(), measured.end(), 0.0, [mean](double sum, double value) {
    return sum + (value - mean) * (value - mean);
  });
  const double error = rmse(axis) * std::sqrt(static_cast<double>(samples_));
  return spread > 0.0 ? 100.0 * (1.0 - error / std::sqrt(spread)) : 0.0;
}

void AxisBlocks::release_buffers() const {
  commands_.release();
  driven_ = {};
}

namespace {

/// Squared errors by the age of the prediction.
class ErrorsByAge {
 public:
  explicit ErrorsByAge(const AxisData& data) : data_(data) {}

  /// @param error  of the block's samples
  void add(const AxisBlocks::Block& block, std::span<const double> error) {
    for (std::size_t age = 0; age < kHorizons_s.size(); ++age) {
      const auto at = static_cast<std::size_t>(std::lround(kHorizons_s[age] / data_.period_s));
      if (at < error.size() && data_.valid[block.begin + at]) {
        sums_[age] += error[at] * error[at];
        counts_[age] += 1.0;
      }
    }
  }

  HorizonErrors rmse() const {
    HorizonErrors out{};
    for (std::size_t age = 0; age < out.size(); ++age) {
      out[age] = counts_[age] > 0.0 ? std::sqrt(sums_[age] / counts_[age]) : 0.0;
    }
    return out;
  }

 private:
  const AxisData& data_;
  HorizonErrors sums_{};
  HorizonErrors counts_{};
};

}  // namespace

HorizonErrors horizon_rmse(const AxisData& data, const std::vector<Range>& ranges, const model::StickAxis& axis) {
  const double longest = kHorizons_s.back() + 2.0 * data.period_s;
  constexpr double kEvery_s = 0.1;
  const auto offsets = static_cast<std::size_t>(std::ceil(longest / kEvery_s));
  ErrorsByAge by_age(data);
  std::vector<double> error;
  for (std::size_t offset = 0; offset < offsets; ++offset) {
    std::vector<Range> shifted = ranges;
    for (Range& range : shifted) {
      range.first += kEvery_s * static_cast<double>(offset);
    }
    const AxisBlocks blocks(data, shifted, longest);
    error.resize(blocks.samples());
    blocks.error(axis, {}, error);
    std::size_t first = 0;
    for (std::size_t number = 0; number < blocks.size(); ++number) {
      const AxisBlocks::Block& block = blocks[number];
      by_age.add(block, std::span(error).subspan(first, block.end - block.begin));
      first += block.end - block.begin;
    }
  }
  return by_age.rmse();
}

}  // namespace m100::lab::identify
