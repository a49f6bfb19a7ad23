// SPDX-License-Identifier: BSD-3-Clause
// Terminal output of a flight. A terminal that is stopped (Ctrl-S), or that nobody reads any more because the session
// over the network broke off, must not stop the flight: a line that it does not take now is lost.
#pragma once

#include <chrono>
#include <string_view>

namespace m100::companion {

/// How long the closing lines wait for a terminal that takes nothing.
constexpr std::chrono::seconds kTerminalTimeout{5};

/// Makes writes to the terminal non-blocking from now on: standard output and error, if they are terminals, are opened
/// anew in non-blocking mode. Other writers to the same terminal, such as the shell, are not affected. A terminal that
/// this user may not open stays as it is.
void make_terminals_nonblocking();

/// Writes as much as the descriptor takes at this moment. Uses neither heap, lock nor stdio.
void write_nonblocking(int descriptor, std::string_view text);

/// After a flight: writes the text to the standard output; gives up when nothing was taken for kTerminalTimeout.
void write_with_timeout(std::string_view text);

}  // namespace m100::companion
