// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"

namespace m100::lab::gains {

/// The number type in which tables are computed. It has more digits than the double in which they are stored.
using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// X with A X = B by LU with partial pivoting: A n x n with n > 0, B n x m. Throws std::domain_error if A is singular.
Matrix solve(const Matrix& a, const Matrix& b);
/// A^-1, A n x n. Throws as solve() does.
inline Matrix inverse(const Matrix& a) { return solve(a, Matrix::Identity(a.rows(), a.rows())); }

/// Stabilising solution of P = Q + A'PA - A'PB (R + B'PB)^-1 B'PA for one input, by iteration to the digits of Real. A
/// and Q n x n, Q symmetric and not negative, B n numbers, R > 0. Throws std::domain_error when it does not converge.
Matrix riccati(const Matrix& a, const Vector& b, const Matrix& q, Real r);

}  // namespace m100::lab::gains
