// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

namespace m100::lab::identify {

/// Processor time of this process until now, in seconds.
inline double processor_s() { return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC); }

}  // namespace m100::lab::identify
