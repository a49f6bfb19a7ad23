// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "firmware/core/eigen.h"
#include "firmware/core/fixed_point.h"
#include "firmware/core/maths.h"

namespace m100::est {

/// State x and covariance P of an extended Kalman filter of kN states, in SI units. S is double, float or core::Fixed.
/// Every sum has one order, so a scalar gives the same bits on every machine.
template <typename S, int kN>
struct Kalman {
  using Vector = core::Vector<S, kN>;
  using Matrix = core::Matrix<S, kN, kN>;
  using Limits = std::array<S, static_cast<std::size_t>(kN)>;

  Vector x = Vector::Zero();
  Matrix p = Matrix::Zero();

  /// x = 0, P diagonal.
  void start(const core::Vector<double, kN>& sigma) {
    x.setZero();
    p = sigma.cwiseAbs2().template cast<S>().asDiagonal();
  }
  /// P <- F P F' + diag(q). @param f makes F v from a vector v
  template <typename Transition>
  void predict(const Transition& f, const Vector& q) {
    Matrix fp;
    for (int i = 0; i < kN; ++i) {
      fp.col(i) = f(p.col(i));
    }
    for (int i = 0; i < kN; ++i) {
      const Vector row = f(fp.row(i));  // of F (F P)'
      for (int j = 0; j <= i; ++j) {
        p(i, j) = p(j, i) = row(j);
      }
      p(i, i) += q(i);
    }
  }
  /// Corrects by the scalar measurement z = H x + noise of variance r:
  ///   s = H P H' + r,  K = P H' / s,  x <- x + K innovation,  P <- (I - K H) P
  /// @param h makes the number H v from a vector v
  /// @returns K
  template <typename Measured>
  Vector correct(const Measured& h, S innovation, S r) {
    const Vector ph = times(h);
    Vector gain = ph / (h(ph) + r);
    subtract(gain, ph);
    x += gain * innovation;
    return gain;
  }
  /// The same in Joseph's form, P <- (I - K H) P (I - K H)' + r K K'. P stays positive where r is smaller than the
  /// rounding of P: 1 m of position against a pose of 0.2 mm in float.
  template <typename Measured>
  Vector correct_joseph(const Measured& h, S innovation, S r) {
    Vector gain = correct(h, innovation, r);
    subtract(times(h) - gain * r, gain);
    return gain;
  }
  /// H P H'
  template <typename Measured>
  S variance_of(const Measured& h) const {
    return h(times(h));
  }
  /// Sets the covariances of state i with the other states to zero, and its variance to `variance`, but at least to
  /// sigma^2 and at most to limit^2, the square of its range.
  void decouple(int i, double variance, double sigma, S limit) {
    p.row(i).setZero();
    p.col(i).setZero();
    const double most = static_cast<double>(limit) * static_cast<double>(limit);
    p(i, i) = S(core::clamp(variance, sigma * sigma, most));
  }
  /// Ends each state at +- its limit.
  void clamp(const Limits& limits) {
    for (int i = 0; i < kN; ++i) {
      const S limit = limits[static_cast<std::size_t>(i)];
      x(i) = core::clamp(x(i), -limit, limit);
    }
  }
  /// Whether all states are numbers and all variances are positive.
  bool is_valid() const {
    bool valid = true;
    for (int i = 0; i < kN; ++i) {
      valid = valid && x(i) == x(i) && p(i, i) > S(0) && p(i, i) < S(kMaxVariance);
    }
    return valid;
  }

 private:
  static constexpr double kMaxVariance = 1e12;  ///< beyond every flight: a position known to 1000 km

  /// P H'
  template <typename Measured>
  Vector times(const Measured& h) const {
    Vector out;
    for (int i = 0; i < kN; ++i) {
      out(i) = h(p.col(i));
    }
    return out;
  }
  /// P <- P - a b', which is symmetric but for rounding.
  void subtract(const Vector& a, const Vector& b) {
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j <= i; ++j) {
        p(j, i) = p(i, j) -= a(i) * b(j);
      }
    }
  }
};

}  // namespace m100::est
