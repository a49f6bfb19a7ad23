// SPDX-License-Identifier: BSD-3-Clause
// What a flight writes for eyes. A terminal that is stopped (Ctrl-S), or that nobody reads any more because the session
// over the network broke off, must not stop the flight: a line that it does not take now is lost.
#pragma once

#include <chrono>
#include <string_view>

namespace m100::companion {

/// How long the words behind a flight wait for a terminal that takes none of them.
constexpr std::chrono::seconds kScreenPatience{5};

/// From here on this program does not wait inside a write to its terminal. Whether a terminal takes a line cannot be
/// asked beforehand: it may be stopped between question and answer, or have room for half of the line. So the standard
/// output and error, where they are terminals, are opened anew without waiting; whoever else writes to the same
/// terminal, the shell first, goes on as before. A terminal that this user may not open stays as it is.
void do_not_wait_for_screens();

/// Writes as much as the screen takes at this moment. Uses neither heap, lock nor stdio.
void write_now(int descriptor, std::string_view text);

/// Behind a flight: writes all of it to the standard output, or what is taken until nothing was for kScreenPatience.
void write_at_last(std::string_view text);

}  // namespace m100::companion
