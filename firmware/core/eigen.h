// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The only firmware header that includes Eigen. Eigen's assertions call our handler, without texts, in all build types.
#include "firmware/core/assert.h"

#ifndef eigen_assert
#define eigen_assert(condition) M100_ASSERT(condition)
#endif

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace m100::core {

template <typename T, int kRows>
using Vector = Eigen::Matrix<T, kRows, 1>;
template <typename T, int kRows, int kCols>
using Matrix = Eigen::Matrix<T, kRows, kCols>;

}  // namespace m100::core
