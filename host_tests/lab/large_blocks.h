// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <malloc.h>

namespace m100::lab {

/// Gives what a long log needed for a moment back to the system at once. Left to itself the allocator keeps ever larger
/// blocks the more of them are freed: an hour of one axis then takes 156 MB at its peak instead of 145.
inline void give_back_large_blocks() {
#ifdef M_MMAP_THRESHOLD
  constexpr int kLarge_bytes = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, kLarge_bytes);
#endif
}

}  // namespace m100::lab
