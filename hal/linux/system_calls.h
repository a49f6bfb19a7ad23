// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstddef>

namespace m100::hal {

/// The calls whose rare answers (EINTR, EIO, short counts) a test wants to choose. Everything else is called directly.
struct SystemCalls {
  ssize_t (*read)(int descriptor, void* destination, std::size_t size);
  ssize_t (*write)(int descriptor, const void* source, std::size_t size);
};

/// The operating system's own.
const SystemCalls& real_system_calls();

}  // namespace m100::hal
