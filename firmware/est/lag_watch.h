// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::est {

/// How far one horizontal axis of the observer may be from the truth beyond its filter's own account, from what the
/// poses have lately done to it.
///
/// The covariance of a Kalman filter holds for the disturbance that it was told of. In a wind that changes faster, d
/// lags behind, and velocity and position with it. The poses show by how much: in a lag that lasts, what they push a
/// state by, per second, is what its rate of change is wrong by. So with nu the innovation, and dp and dv what the
/// corrections add to position and velocity, all as means over some poses:
///   error of the position = nu,  of the velocity = dp / dt,  of the acceleration = dv / dt.
/// Their mean products over a gust or two, less what is left in such means of noise that differs from pose to pose, are
/// added to what the filter claims; while no pose comes they grow for a second as such errors do, p by v t + a t^2 / 2
/// and v by a t. How they go together is not claimed: then the claim holds whatever that is.
///
/// Where the innovations are smaller than claimed (poses better than the vehicle file says, no wind), the filter's own
/// part shrinks with their normalised square (NIS), to a half at the least, and only while poses come.
/// Memory: ten numbers. Cost: about 50 products a pose, 25 a tick. T is float or double.
template <typename T>
class LagWatch {
 public:
  /// Of position and velocity.
  struct Covariance {
    T pp_m2{0}, pv_m2_s{0}, vv_m2_s2{0};
  };

  /// A pose was used. @param pushed_m, pushed_m_s what it added to position and velocity
  /// @param nis square of the innovation over its variance. @param interval_s since the last pose that was used
  void note(T innovation_m, T pushed_m, T pushed_m_s, T nis, T interval_s);

  /// @param own of the filter. @param age_s of the newest pose that was used. @param since_s since it was used
  /// @param felt a force tells the push meanwhile: the error of the acceleration is that of its offset
  Covariance claimed(const Covariance& own, T age_s, T since_s, bool felt = false) const;

 private:
  /// Errors of position, velocity and acceleration.
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

extern template class LagWatch<float>;
extern template class LagWatch<double>;

}  // namespace m100::est
