// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace m100::companion {

/// Serial ports of this machine, by their lasting names (/dev/serial/by-id) where they have one: USB adapters first,
/// then the board's own.
std::vector<std::string> serial_ports();

/// What to do about a port that does not exist.
std::string missing_port_remedy(const std::string& port);
/// " (also open in cat, process 1234; if it reads, it takes bytes away)": the processes that have opened a port, other
/// than this program and its backup process, found in /proc. Without root only those of the same user are found. Empty:
/// there is none.
std::string holders_note(const std::string& port);

}  // namespace m100::companion
