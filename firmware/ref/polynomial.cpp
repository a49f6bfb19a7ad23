// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/polynomial.h"

namespace m100::ref {

Polynomial<double> through(const EndStates& ends) {
  const auto& [p0, v0, a0, j0] = ends.start;
  const double dp = ends.end[0] - (p0 + v0 + a0 / 2.0 + j0 / 6.0);
  const double dv = ends.end[1] - (v0 + a0 + j0 / 2.0);
  const double da = ends.end[2] - (a0 + j0);
  const double dj = ends.end[3] - j0;
  return {.c = {p0, v0, a0 / 2.0, j0 / 6.0,                    //
                35.0 * dp - 15.0 * dv + 2.5 * da - dj / 6.0,   //
                -84.0 * dp + 39.0 * dv - 7.0 * da + dj / 2.0,  //
                70.0 * dp - 34.0 * dv + 6.5 * da - dj / 2.0,   //
                -20.0 * dp + 10.0 * dv - 2.0 * da + dj / 6.0}};
}

Polynomial<double> quintic(double from, double to) {
  const double way = to - from;
  return {.c = {from, 0.0, 0.0, 10.0 * way, -15.0 * way, 6.0 * way, 0.0, 0.0}};
}

}  // namespace m100::ref
