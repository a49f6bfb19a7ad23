// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "firmware/model/stick_axis.h"

namespace m100::lab::identify {

struct AxisData;

/// The commands that an axis makes of the stick, along stretches of a log. The results for two axes are kept, because
/// most steps of a search change only parameters that act after the commands, or only the gain.
class StickCommands {
 public:
  struct Stretch {
    std::size_t past;   ///< first sample whose stick is used
    std::size_t begin;  ///< a drift counts its time from the start of the flight of this sample
    std::size_t end;
  };
  /// @param keep_counts  whether the counts before the gain are kept, for fits with many steps of the gain
  explicit StickCommands(bool keep_counts) : keep_counts_(keep_counts) {}

  void add(const Stretch& stretch) { stretches_.push_back(stretch); }
  std::size_t size() const { return stretches_.size(); }
  const Stretch& operator[](std::size_t stretch) const { return stretches_[stretch]; }
  /// Commands from `past` to `end`, valid until a third axis is requested. `data` must be the same in every call.
  const std::vector<double>& of(const AxisData& data, const model::StickAxis& axis, std::size_t stretch) const;
  void release() const { results_ = {}; }

 private:
  struct Result {
    model::StickAxis axis;
    std::vector<std::vector<double>> commands;                       ///< by stretch
    std::vector<std::shared_ptr<const std::vector<double>>> counts;  ///< before the gain
    std::vector<char> known;
  };
  Result& result_for(const model::StickAxis& axis) const;

  bool keep_counts_;
  std::vector<Stretch> stretches_;
  mutable std::array<Result, 2> results_;
  mutable std::size_t last_ = 0;
};

/// Applies the axis' transport delay and lead zero to the commands, and writes the result from index `first` on. A
/// negative delay uses later commands. Beyond the ends of `commands` its first or last value is used.
void arrived_commands(const std::vector<double>& commands, const model::StickAxis& axis, double period_s,
                      std::size_t first, std::span<double> out);

}  // namespace m100::lab::identify
