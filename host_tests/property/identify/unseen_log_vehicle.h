// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace m100::host_tests {

/// Random numbers from one seed.
class UnseenLogRandom {
 public:
  explicit UnseenLogRandom(const std::mt19937_64& random) : random_(random) {}
  explicit UnseenLogRandom(std::uint64_t seed)
      : UnseenLogRandom(std::mt19937_64(seed * 2862933555777941757ULL + 3037000493ULL)) {}
  double between(double low, double high) { return low + (high - low) * uniform_(random_); }
  double normal() { return normal_(random_); }
  double sign() { return uniform_(random_) < 0.5 ? -1.0 : 1.0; }
  bool one_in(double count) { return uniform_(random_) * count < 1.0; }
  template <typename Value>
  Value any_of(const std::vector<Value>& values) {
    return values[static_cast<std::size_t>(uniform_(random_) * static_cast<double>(values.size()))];
  }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::normal_distribution<double> normal_;
};

/// Parameters of one axis, of the flown or the believed vehicle. Unit of the response: rad (roll, pitch), m/s (climb).
struct UnseenLogParameters {
  double gain = 9e-4;  ///< per count
  double frequency_rad_s = 8.0;
  double damping = 0.7;
  double lag_s = 0.0;    ///< of motors and rotors, first order, in addition to the second order
  double delay_s = 0.0;  ///< negative: the response precedes the stick
  double dead_zone_counts = 0.0;
  double trim_counts = 0.0;
  double backlash_counts = 0.0;  ///< half width
  double asymmetry = 1.0;        ///< gain to the right over gain to the left; their mean is `gain`
  double exponent = 1.0;         ///< of the stick's curve over 660 counts
  double saturation = 1e9;       ///< of the command, unit of the response
  double rate_limit_per_s = 1e9;
  double drift_per_minute = 0.0;
  double cross = 0.0;         ///< gain of the other stick
  double lead_s = 0.0;        ///< zero of the command, after a filter of 5 ms
  double spring_per_s = 0.0;  ///< of a tether: pulls the response back in proportion to the distance beyond tether_m
  double tether_m = 0.0;
};

/// Both sticks as received, on the simulation's clock.
struct UnseenLogSticks {
  std::vector<double> own, other;  ///< counts from neutral
};

inline constexpr double kUnseenLogStep_s = 0.00125;

/// The response without air and noise, step by step, by a Heun integrator that shares no code with the tested code.
class UnseenLogVehicle {
 public:
  explicit UnseenLogVehicle(const UnseenLogParameters& traits) : traits_(traits) {}
  /// Changes the vehicle; its state stays.
  void set_parameters(const UnseenLogParameters& traits) { traits_ = traits; }
  /// Advances by kStrangerStep_s. @param now  the step's number; @returns the response before the step.
  double step(const UnseenLogSticks& sticks, std::size_t now);
  void stop() { angle_ = rate_ = filtered_ = lagged_ = 0.0; }

 private:
  double command(const UnseenLogSticks& sticks, std::size_t now);
  double arrived(const std::vector<double>& stick, std::size_t now) const;

  UnseenLogParameters traits_;
  double play_ = 0.0;
  double filtered_ = 0.0;
  double lagged_ = 0.0;
  double angle_ = 0.0;
  double rate_ = 0.0;
  double flown_m_ = 0.0;
};

/// The whole response of a vehicle whose parameters change at change_s.
std::vector<double> response_of(const UnseenLogParameters& before, const UnseenLogParameters& after, double change_s,
                                const UnseenLogSticks& sticks);

/// Style of the stick's source: a pilot or a closed loop.
enum class UnseenLogInput { kPilot, kSines, kDoublets, kHolds, kBangBang, kLoop };

class UnseenLogPilot {
 public:
  /// @param reach  typical deflection, counts; @param feedback  counts per unit of the response, for kLoop
  UnseenLogPilot(UnseenLogInput hand, double reach, double feedback, UnseenLogRandom& rng);
  /// @param seen  the response as measured
  double next(double t_s, double seen);

 private:
  double target_of(double t_s);
  void go_on_with_doublet(double t_s);

  UnseenLogInput hand_;
  double reach_;
  double feedback_;
  UnseenLogRandom& chance_;
  double next_s_ = 0.5;
  double target_ = 0.0;
  double half_ = 0.0;  ///< half of a doublet that is still to come
  double first_ = 0.0;
  double stick_ = 0.0;
  std::vector<double> hz_, phase_;
};

}  // namespace m100::host_tests
