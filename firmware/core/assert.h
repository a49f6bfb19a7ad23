// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::core {

/// Called when an invariant of our own code is violated. It must not return. The default stops the program; the flight
/// program installs one that sends neutral sticks and releases control.
using AssertionHandler = void (*)(const char* file, int line);

/// Replaces the handler and returns the former one (null: the default). Not thread-safe; call it before the first tick.
AssertionHandler set_assertion_handler(AssertionHandler handler);

/// Calls the handler. Traps if there is none or if it returns.
[[noreturn]] void assertion_failed(const char* file, int line);

}  // namespace m100::core

/// Checks an invariant of our own code, in every build type. Bad input is no violated invariant: report it as a Status.
#define M100_ASSERT(condition) \
  (static_cast<bool>(condition) ? void() : ::m100::core::assertion_failed(__FILE__, __LINE__))
