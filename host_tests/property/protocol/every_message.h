// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/property/protocol/streams.h"

namespace m100::host_tests {

struct NamedFrame {
  std::string name;
  Bytes bytes;
};

/// One frame of each message of the catalogue with values that are not zero, plain and encrypted, and one of each kind
/// of acknowledgement.
std::vector<NamedFrame> every_message();

}  // namespace m100::host_tests
