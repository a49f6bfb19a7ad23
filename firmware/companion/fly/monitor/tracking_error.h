// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>

#include "firmware/companion/operator/text_line.h"
#include "firmware/core/eigen.h"
#include "firmware/core/time.h"
#include "firmware/ref/window.h"

namespace m100::companion {

/// Distance between the estimate and the reference of the same time while the law flies. It counts from one second
/// after the law first flew: before that the aircraft goes to the course. A distance that is not a number is not
/// counted.
class TrackingError {
 public:
  static constexpr core::Duration kSettle = std::chrono::seconds(1);

  /// Once per tick in which the law flies. @param position_m estimate at `now`, world. @param reference of this tick:
  /// its horizontal points lead by `lead` (ref::Window).
  void update(core::TimePoint now, const core::Vector<double, 3>& position_m, const ref::Window<double>& reference,
              core::Duration lead) {
    began_ = began_ ? began_ : now;
    newest_ = (newest_ + 1) % kKept;
    leading_[newest_] = {now + lead, {reference.x[0].position_m, reference.y[0].position_m}};
    if (now - *began_ >= kSettle) {
      const core::Vector<double, 2> horizontal = position_m.head<2>() - reference_at(now);
      add({horizontal.x(), horizontal.y(), position_m.z() - reference.height.position_m});
    }
  }
  bool is_known() const { return count_ > 0; }
  double horizontal_rms_m() const { return rms(horizontal_m2_); }
  double vertical_rms_m() const { return rms(vertical_m2_); }
  double rms_m() const { return rms(horizontal_m2_ + vertical_m2_); }
  double max_m() const { return std::sqrt(largest_m2_); }

 private:
  static constexpr std::size_t kKept = 64;  ///< ticks: longer than any lead
  struct Point {
    core::TimePoint at{};
    core::Vector<double, 2> position_m = core::Vector<double, 2>::Zero();
  };

  /// The horizontal reference at a time, linear between two ticks.
  core::Vector<double, 2> reference_at(core::TimePoint now) const {
    const Point* after = &leading_[newest_];
    for (std::size_t ago = 1; ago < kKept && after->at > now; ++ago) {
      const Point& before = leading_[(newest_ + kKept - ago) % kKept];
      if (before.at <= now) {
        const double share = core::seconds<double>(now - before.at) / core::seconds<double>(after->at - before.at);
        return before.position_m + share * (after->position_m - before.position_m);
      }
      after = &before;
    }
    return after->position_m;
  }
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
  double rms(double sum_m2) const { return count_ > 0 ? std::sqrt(sum_m2 / static_cast<double>(count_)) : 0.0; }

  std::optional<core::TimePoint> began_;
  std::array<Point, kKept> leading_{};
  std::size_t newest_ = 0;
  double horizontal_m2_ = 0.0;
  double vertical_m2_ = 0.0;
  double largest_m2_ = 0.0;
  std::uint64_t count_ = 0;
};

inline TextLine describe(const TrackingError& error) {
  TextLine line;
  line.add("tracking error ")
      .add(error.rms_m(), 3)
      .add(" m rms, ")
      .add(error.max_m(), 3)
      .add(" m at most (horizontal ");
  return line.add(error.horizontal_rms_m(), 3).add(" m rms, vertical ").add(error.vertical_rms_m(), 3).add(" m rms)");
}

}  // namespace m100::companion
