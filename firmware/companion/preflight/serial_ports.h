// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::companion {

/// Serial ports of this machine, by their lasting names (/dev/serial/by-id) where they have one: USB adapters first,
/// then the board's own.
std::vector<std::string> serial_ports();

}  // namespace m100::companion
