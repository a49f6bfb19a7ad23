// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/dense.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "firmware/core/assert.h"

namespace m100::lab::gains {

Matrix solve(const Matrix& a, const Matrix& b) {
  M100_ASSERT(a.rows() > 0 && a.cols() == a.rows() && b.rows() == a.rows());
  const Eigen::PartialPivLU<Matrix> lu(a);
  if (!(lu.matrixLU().diagonal().cwiseAbs().minCoeff() > 0)) {  // also true for NaN
    throw std::domain_error("singular matrix");
  }
  return lu.solve(b);
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
