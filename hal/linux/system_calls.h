// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <linux/serial.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <cstddef>

namespace m100::hal {

/// Opens a device for reading and writing without blocking. @returns the descriptor; -1: errno has the reason.
int open_device(const char* path);

/// The driver's counts of the line (TIOCGICOUNT). @returns 0; -1: errno has the reason.
int read_line_counters(int descriptor, serial_icounter_struct* counters);

/// The bytes that wait in a terminal (FIONREAD). read() and poll() of an empty terminal wait for a worker of the kernel
/// that has normal priority and may get no processor; this call does not. @returns 0; -1: errno has the reason.
int count_waiting(int descriptor, int* bytes);

/// The system calls that a test replaces, to choose rare results (EINTR, EIO, short counts, broken lines) or to observe
/// the call. All others are called directly.
struct SystemCalls {
  ssize_t (*read)(int descriptor, void* destination, std::size_t size) = &::read;
  ssize_t (*write)(int descriptor, const void* source, std::size_t size) = &::write;
  int (*open)(const char* path) = &open_device;
  int (*waiting)(int descriptor, int* bytes) = &count_waiting;
  int (*line_counters)(int descriptor, serial_icounter_struct* counters) = &read_line_counters;
  int (*sleep)(clockid_t clock, int flags, const timespec* until, timespec* remaining) = &::clock_nanosleep;
};

const SystemCalls& real_system_calls();

}  // namespace m100::hal
