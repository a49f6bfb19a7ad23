// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::est {

/// Estimates errors of one horizontal axis of the observer that its filter's covariance does not include.
///
/// In a wind that changes faster than the filter's model assumes, the estimated disturbance lags, and velocity and
/// position lag with it. The recent corrections by poses show the errors. With nu the innovation, dp and dv the
/// corrections of position and velocity and dt the time between poses, all averaged over some poses:
///   error of the position = nu,  of the velocity = dp / dt,  of the acceleration = dv / dt.
/// The mean products of these errors over 3 s, less the part that white noise of the poses causes, are added to the
/// filter's variances. The added variances grow with the age of the newest pose, for up to 1 s.
///
/// While poses come whose innovations are smaller than predicted, the filter's own covariance is multiplied by their
/// mean normalised square (NIS), by at least 0.25. Memory: ten numbers. Cost: about 50 products a pose, 25 a tick. T is
/// float or double.
template <typename T>
class CovarianceInflation {
 public:
  struct Covariance {
    T pp_m2{0}, pv_m2_s{0}, vv_m2_s2{0};
  };

  /// Takes a pose that was used.
  /// @param correction_m, correction_m_s the corrections that it made to position and velocity
  /// @param nis square of the innovation over its variance
  /// @param interval_s time since the pose before it was used
  void update(T innovation_m, T correction_m, T correction_m_s, T nis, T interval_s);

  /// The covariance to report.
  /// @param own covariance of the filter
  /// @param age_s time since the newest used pose was captured
  /// @param since_s time since that pose was used
  /// @param force_known the force measures the disturbance: the error of the acceleration is then kForceOffset_m_s2
  Covariance inflated(const Covariance& own, T age_s, T since_s, bool force_known = false) const;

 private:
  struct Error {
    T p_m{0}, v_m_s{0}, a_m_s2{0};
  };
  struct Products {
    T pp{0}, pv{0}, vv{0}, pa{0}, va{0}, aa{0};
  };
  static Products products(const Error& e);

  Error now_;
  Products mean_;
  T nis_{1};
};

extern template class CovarianceInflation<float>;
extern template class CovarianceInflation<double>;

}  // namespace m100::est
