// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/catalogue.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace m100::authority {

std::span<const Fault> catalogue() {
  static const std::vector<Fault> all = [] {
    std::vector<Fault> faults;
    for (const std::span<const Fault> part :
         {line_faults(), authority_faults(), port_faults(), process_faults(), pose_faults()}) {
      std::copy_if(part.begin(), part.end(), std::back_inserter(faults),
                   [](const Fault& fault) { return !fault.needs_mount || can_mount(); });
    }
    return faults;
  }();
  return all;
}

}  // namespace m100::authority
