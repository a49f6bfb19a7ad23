// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "host_tests/oracle/axis_vehicle.h"
#include "host_tests/oracle/random.h"

namespace m100::host_tests {

/// Both sticks as received, on the simulation's clock.
struct UnseenLogSticks {
  std::vector<double> own, other;  ///< counts from neutral
};

inline constexpr double kUnseenLogStep_s = 0.00125;

/// The whole response of a vehicle whose parameters change at change_s.
std::vector<double> response_of(const oracle::AxisParameters& before, const oracle::AxisParameters& after,
                                double change_s, const UnseenLogSticks& sticks);

/// Style of the stick's source: a pilot or a closed loop.
enum class UnseenLogInput { kPilot, kSines, kDoublets, kHolds, kBangBang, kLoop };

class UnseenLogPilot {
 public:
  /// @param reach  typical deflection, counts; @param feedback  counts per unit of the response, for kLoop
  UnseenLogPilot(UnseenLogInput hand, double reach, double feedback, oracle::Random& rng);
  /// @param seen  the response as measured
  double next(double t_s, double seen);

 private:
  double target_of(double t_s);
  void go_on_with_doublet(double t_s);

  UnseenLogInput hand_;
  double reach_;
  double feedback_;
  oracle::Random& chance_;
  double next_s_ = 0.5;
  double target_ = 0.0;
  double half_ = 0.0;  ///< half of a doublet that is still to come
  double first_ = 0.0;
  double stick_ = 0.0;
  std::vector<double> hz_, phase_;
};

}  // namespace m100::host_tests
