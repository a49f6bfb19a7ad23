// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "firmware/companion/operator/text_line.h"
#include "firmware/core/eigen.h"

namespace m100::companion {

/// Distance between the estimate and the reference while the law flies. Errors: none; not a number is not counted.
class TrackingError {
 public:
  /// @param error_m estimate minus reference, world
  void add(const core::Vector<double, 3>& error_m) {
    const double squared = error_m.squaredNorm();
    if (!std::isfinite(squared)) {
      return;
    }
    horizontal_m2_ += error_m.head<2>().squaredNorm();
    vertical_m2_ += error_m.z() * error_m.z();
    largest_m2_ = std::max(largest_m2_, squared);
    ++count_;
  }
  bool is_known() const { return count_ > 0; }
  double horizontal_rms_m() const { return rms(horizontal_m2_); }
  double vertical_rms_m() const { return rms(vertical_m2_); }
  double rms_m() const { return rms(horizontal_m2_ + vertical_m2_); }
  double max_m() const { return std::sqrt(largest_m2_); }

 private:
  double rms(double sum_m2) const { return count_ > 0 ? std::sqrt(sum_m2 / static_cast<double>(count_)) : 0.0; }

  double horizontal_m2_ = 0.0;
  double vertical_m2_ = 0.0;
  double largest_m2_ = 0.0;
  std::uint64_t count_ = 0;
};

inline void describe(TextLine& line, const TrackingError& error) {
  line.add("tracking error ")
      .add(error.rms_m(), 3)
      .add(" m rms, ")
      .add(error.max_m(), 3)
      .add(" m at most (horizontal ");
  line.add(error.horizontal_rms_m(), 3).add(" m rms, vertical ").add(error.vertical_rms_m(), 3).add(" m rms)");
}

}  // namespace m100::companion
