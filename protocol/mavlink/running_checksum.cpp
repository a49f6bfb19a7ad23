// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/running_checksum.h"

#include <algorithm>

namespace m100::mavlink {

void RunningChecksum::shift(std::size_t bytes) {
  const std::size_t blocks = bytes / kBlockBytes;
  if (known_ < blocks) {
    known_ = 0;
    return;
  }
  std::copy(registers_.begin() + static_cast<std::ptrdiff_t>(blocks),
            registers_.begin() + static_cast<std::ptrdiff_t>(known_ + 1), registers_.begin());
  known_ -= blocks;
}

}  // namespace m100::mavlink
