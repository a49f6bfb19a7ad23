// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include "firmware/est/filter/disturbance_ekf.h"

namespace m100::est {

/// The observer in each of its scalar types, with the type of its estimate, for typed tests.
struct InDouble {
  using Filter = DoubleEkf;
  using Real = double;
};
struct InFloat {
  using Filter = FloatEkf;
  using Real = float;
};
struct InFixed {
  using Filter = FixedEkf;
  using Real = float;
};
using Scalars = ::testing::Types<InDouble, InFloat, InFixed>;

}  // namespace m100::est
