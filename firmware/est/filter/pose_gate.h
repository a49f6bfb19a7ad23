// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"
#include "firmware/est/filter/covariance_inflation.h"

// Shared by the filters of a horizontal axis and of the height, and by DisturbanceEkf.
namespace m100::est {

inline constexpr double kGateSigmas = 6.0;
inline constexpr double kLargestInnovation_m = 1.0;

/// Largest variance of a pose: a sigma of 1 km is no information beside the range of the position, 100 m.
inline constexpr double kMaxPoseVariance_m2 = 1e6;

/// Innovation of a position.
template <typename S>
struct PoseInnovation {
  S age_s{0};         ///< of the pose
  S innovation_m{0};  ///< the pose minus its prediction
  S variance_m2{0};   ///< of the innovation
  S noise_m2{0};      ///< part of it: the variance of the pose
  bool inside = false;

  /// The square of the innovation over its variance; its expectation is 1.
  template <typename Real>
  Real normalised_square() const {
    const Real distance_m = static_cast<Real>(innovation_m);
    return distance_m * distance_m / static_cast<Real>(variance_m2);
  }
};

/// Whether an innovation is at most 6 sigmas or at most unseen_m. One above 1 m is inside only if it is at most 6
/// sigmas of the pose's own noise: without this, only the poses near the prediction would be used, and they would
/// confirm it.
template <typename S>
bool inside_gate(S innovation_m, S variance_m2, S noise_m2, S unseen_m) {
  const S size_m = innovation_m < S(0) ? -innovation_m : innovation_m;
  const bool is_near = size_m <= S(kLargestInnovation_m);
  return size_m * size_m <= S(kGateSigmas * kGateSigmas) * (is_near ? variance_m2 : noise_m2) ||
         (is_near && size_m <= unseen_m);
}

/// The innovation of a pose on one axis, and whether it is inside the gate.
/// @param h makes the number H v from a vector v
/// @param moved_m AccelerationHistory::displacement() since the capture, which H x leaves out
template <typename Filter, typename Measured, typename S>
PoseInnovation<S> test_pose(const Filter& filter, const Measured& h, S position_m, S age_s, S moved_m, S noise_m2,
                            S unseen_m) {
  PoseInnovation<S> test{.age_s = age_s, .innovation_m = position_m - h(filter.x) - moved_m, .noise_m2 = noise_m2};
  test.variance_m2 = filter.variance_of(h) + noise_m2;
  test.inside = inside_gate(test.innovation_m, test.variance_m2, noise_m2, unseen_m);
  return test;
}

/// The largest innovation that inside_gate() accepts, for messages and the log; m.
template <typename Real>
Real gate_m(Real variance_m2, Real noise_m2, Real unseen_m) {
  const auto sigmas_m = [](Real variance) { return static_cast<Real>(kGateSigmas) * core::sqrt(variance); };
  const Real gate = sigmas_m(variance_m2) > unseen_m ? sigmas_m(variance_m2) : unseen_m;
  const Real most = core::clamp(sigmas_m(noise_m2), static_cast<Real>(kLargestInnovation_m), gate);
  return gate < most ? gate : most;
}

/// Distance that the gate allows for the lag of the estimated disturbance: six sigmas of the position error that
/// CovarianceInflation adds, at most 0.5 m.
template <typename Real>
Real lag_m(const CovarianceInflation<Real>& inflation, Real since_s) {
  const Real variance_m2 = inflation.inflated({}, since_s, since_s).pp_m2;
  return core::clamp(static_cast<Real>(kGateSigmas) * core::sqrt(variance_m2), Real(0),
                     static_cast<Real>(0.5 * kLargestInnovation_m));
}

/// Measurement variance of a pose on one axis, and the distance that passes the gate whatever the sigmas are.
template <typename Real>
struct PoseWeight {
  Real variance_m2{0};
  Real unseen_m{0};
};

/// The variance is the claimed one plus the square of the distance flown in the uncertainty of the time of capture. The
/// gate uses all of this distance, the variance at most 30 mm.
/// @param claimed_m2 the larger of the vehicle file's variance and the sender's
/// @param way_m that distance
template <typename Real>
PoseWeight<Real> weight_of(Real claimed_m2, Real way_m, Real unseen_m) {
  constexpr Real kMaxTimingError_m2 = static_cast<Real>(0.03 * 0.03);
  constexpr Real kMax_m2 = static_cast<Real>(kMaxPoseVariance_m2);
  const Real pose_m2 = claimed_m2 < kMax_m2 ? claimed_m2 : kMax_m2;
  const Real way_m2 = way_m * way_m;
  if (way_m2 <= kMaxTimingError_m2) {
    return {.variance_m2 = pose_m2 + way_m2, .unseen_m = unseen_m};
  }
  return {.variance_m2 = pose_m2 + kMaxTimingError_m2,
          .unseen_m = core::clamp(static_cast<Real>(kGateSigmas) * core::sqrt(pose_m2 + way_m2), unseen_m,
                                  static_cast<Real>(kLargestInnovation_m))};
}

/// The refusal of a pose, on the axis with the largest ratio of distance to gate.
template <typename Real, typename S>
Refusal<Real> refusal_of(Real turned_rad, Real unseen_m, std::initializer_list<PoseInnovation<S>> tests) {
  Refusal<Real> worst{.turned_rad = turned_rad < Real(0) ? -turned_rad : turned_rad};
  for (const PoseInnovation<S>& test : tests) {
    const Real innovation_m = static_cast<Real>(test.innovation_m);
    const Real distance_m = innovation_m < Real(0) ? -innovation_m : innovation_m;
    const Real allowed_m = gate_m(static_cast<Real>(test.variance_m2), static_cast<Real>(test.noise_m2), unseen_m);
    if (distance_m * worst.allowed_m >= worst.distance_m * allowed_m) {
      worst.distance_m = distance_m;
      worst.allowed_m = allowed_m;
    }
  }
  return worst;
}

}  // namespace m100::est
