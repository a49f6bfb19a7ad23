// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/gains/dense.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace m100::tools::gains {

Matrix solve(Matrix a, Matrix b) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      pivot = std::abs(a(i, k)) > std::abs(a(pivot, k)) ? i : pivot;
    }
    if (!(std::abs(a(pivot, k)) > 0)) {
      throw std::domain_error("singular matrix");
    }
    a.row(k).swap(a.row(pivot));
    b.row(k).swap(b.row(pivot));
    for (Eigen::Index i = k + 1; i < n; ++i) {
      const Real factor = a(i, k) / a(k, k);
      a.row(i) -= factor * a.row(k);
      b.row(i) -= factor * b.row(k);
    }
  }
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    b.row(k) /= a(k, k);
    for (Eigen::Index i = 0; i < k; ++i) {
      b.row(i) -= a(i, k) * b.row(k);
    }
  }
  return b;
}

Matrix exponential(const Matrix& a) {
  int halvings = 0;
  const Real norm = a.cwiseAbs().rowwise().sum().maxCoeff();
  while (std::ldexp(norm, -halvings) > Real(0.25)) {
    ++halvings;
  }
  const Matrix scaled = a * std::ldexp(Real(1), -halvings);
  Matrix sum = Matrix::Identity(a.rows(), a.cols());
  Matrix term = sum;
  for (int n = 1; n <= 24; ++n) {  // 0.25^24 / 24! is below 1e-37
    term = term * scaled / Real(n);
    sum += term;
  }
  for (int n = 0; n < halvings; ++n) {
    sum = sum * sum;
  }
  return sum;
}

Matrix riccati(const Matrix& a, const Vector& b, const Matrix& q, Real r) {
  Matrix p = q;
  for (int n = 0; n < 1000000; ++n) {
    const Vector pb = p * b;
    const Vector gain = a.transpose() * pb / (r + b.dot(pb));
    Matrix next = q + a.transpose() * p * a - gain * (pb.transpose() * a);
    next = (next + next.transpose()) * Real(0.5);
    const Real change = (next - p).cwiseAbs().maxCoeff();
    p = next;
    if (change <= 4 * std::numeric_limits<Real>::epsilon() * p.cwiseAbs().maxCoeff()) {
      return p;
    }
    if (!std::isfinite(change)) {
      break;
    }
  }
  throw std::domain_error("the Riccati iteration does not settle");
}

}  // namespace m100::tools::gains
