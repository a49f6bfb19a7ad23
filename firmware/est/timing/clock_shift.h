// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::est {

/// Detects that the clock of a source of poses was set or slewed, and by how much.
///
/// If poses arrive later than their stamps say, either the transport has become slower or the source's clock has lost
/// time. If the transport is slower, the stamps stay one capture interval apart. If the clock has lost time, they are
/// less than that apart. So, over windows of some poses,
///   shift   = smallest (arrival - stamp) of the window, minus that of earlier windows
///   deficit = number of captures x their interval - advance of the stamps
/// and the clock is the cause if shift and deficit differ by less than half of the shift. If the source captures or
/// stamps irregularly, the shift is only reported as unexplained_s().
///
/// Cost: five products and two divisions a pose.
class ClockShift {
 public:
  /// One pose, or the newest of several that came in one tick.
  struct Step {
    float stamps_s = 0.F;  ///< from the stamp before to this one, positive
    float slip_s = 0.F;    ///< how much longer the step between the arrivals was
    float poses = 1.F;     ///< that came in this step
  };
  /// @param spread_s 99th percentile of the jitter of the arrivals
  /// @returns the time that the clock has lost since the last nonzero result (negative: gained); 0: none, or too little
  float update(const Step& step, float spread_s);
  /// Deviation of the stamps from a whole number of captures in the time between two arrivals.
  float uneven_s(float stamps_s, float arrivals_s) const { return stamps_s - captures(arrivals_s) * spacing_s_; }
  float spacing_s() const { return spacing_s_; }
  /// How much later the poses came in the last window, if the source is too irregular to show the cause; otherwise 0.
  float unexplained_s() const { return unexplained_s_; }
  /// Whether the source is known, and captures and stamps regularly.
  bool is_regular() const;

 private:
  static constexpr std::uint32_t kWindow = 8;   ///< poses: the smallest of their jitters is a ninth of the spread
  static constexpr std::uint32_t kLearns = 30;  ///< poses, before the first is judged
  float captures(float step_s) const;
  void learn(const Step& step);
  float judge(float spread_s);

  std::uint32_t learnt_ = 0;
  float spacing_s_ = 0.F;  ///< between two captures
  float uneven_s2_ = 0.F;  ///< mean square of a step's deviation from whole spacings
  float shift_s_ = 0.F;
  float deficit_s_ = 0.F;
  float unexplained_s_ = 0.F;
  float least_shift_s_ = 0.F;       ///< of the window
  float deficit_at_least_s_ = 0.F;  ///< at the same pose
  float stamps_s_ = 0.F;            ///< sum of the steps of the window
  float captures_ = 0.F;            ///< captures in the window
  std::uint32_t poses_ = 0;
  bool has_window_ = false;
};

}  // namespace m100::est
