// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/dense.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "firmware/core/assert.h"

namespace m100::lab::gains {

Matrix solve(Matrix a, Matrix b) {
  const Eigen::Index n = a.rows();
  M100_ASSERT(a.cols() == n && b.rows() == n);
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

Matrix riccati(const Matrix& a, const Vector& b, const Matrix& q, Real r) {
  M100_ASSERT(a.rows() == a.cols() && b.size() == a.rows() && q.rows() == a.rows() && q.cols() == a.rows() && r > 0);
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

}  // namespace m100::lab::gains
