// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"

namespace m100::tools::gains {

/// Tables are made in more digits than they are kept in, so that a double entry is the rounded true one.
using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// X with A X = B, Gaussian elimination with partial pivoting. A square; throws std::domain_error when it is singular.
Matrix solve(Matrix a, Matrix b);
inline Matrix inverse(const Matrix& a) { return solve(a, Matrix::Identity(a.rows(), a.rows())); }

/// exp(A) by scaling and squaring of the Taylor series, to the digits of Real.
Matrix exponential(const Matrix& a);

/// Stabilising solution of P = Q + A'PA - A'PB (R + B'PB)^-1 B'PA for one input, by iteration to the digits of Real.
/// Throws std::domain_error when it does not settle.
Matrix riccati(const Matrix& a, const Vector& b, const Matrix& q, Real r);

}  // namespace m100::tools::gains
