// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::lab {

/// 97.5 % quantile of Student's t (Abramowitz and Stegun 26.7.5): exact to 1 % from three degrees of freedom on.
inline double student_t(double degrees) {
  return 1.959964 + (2.3723 + (2.8225 + 2.5559 / degrees) / degrees) / degrees;
}

}  // namespace m100::lab
