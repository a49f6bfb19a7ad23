// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::hal {

/// Exit status of QEMU after a fault, an interrupt without a handler, or a failed M100_ASSERT without one (a trap).
inline constexpr int kExitOfFault = 70;
/// Exit status after a failed M100_ASSERT with a handler (fail_assertion or the program's own).
inline constexpr int kExitOfAssertion = 71;
/// Exit status after abort() or a pure virtual call.
inline constexpr int kExitOfAbort = 72;
/// Exit status after the watchdog's interrupt, when the program has sent its release sequence.
inline constexpr int kExitOfWatchdog = 73;

/// For core::set_assertion_handler: prints which assertion failed and ends the emulation.
[[noreturn]] void fail_assertion(const char* file, int line);

}  // namespace m100::hal
