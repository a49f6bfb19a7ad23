// SPDX-License-Identifier: BSD-3-Clause
// R1 on the shipped program: linked into m100 with the same objects, and with malloc and ioctl wrapped by the linker,
// this file counts the allocations of the flying thread from the end of its first tick to the end of its last one. A
// tick ends when it asks how many bytes wait at standard input. At its end the program prints the sum on standard
// error. With M100_NO_HEAP set, for tests that check output and exit code, it prints nothing and ends with exit code 99
// if the sum is not zero.
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

namespace {

std::atomic<unsigned long> allocations{0};  // of the main thread; atomic, because another thread may read it at the end
unsigned long at_first_tick = 0;
unsigned long at_last_tick = 0;
unsigned long ticks = 0;

bool is_main_thread() { return ::syscall(SYS_gettid) == ::getpid(); }
void count() {
  if (is_main_thread()) {
    ++allocations;
    if (ticks > 0 && std::getenv("M100_STOP_AT_ALLOCATION") != nullptr) {
      std::abort();  // for a debugger
    }
  }
}

struct Report {
  ~Report() {
    const bool quiet = std::getenv("M100_NO_HEAP") != nullptr && at_last_tick == at_first_tick;
    if (ticks > 1 && !quiet) {
      std::fprintf(stderr, "the thread that flies allocated %lu times in %lu ticks\n", at_last_tick - at_first_tick,
                   ticks);
      if (std::getenv("M100_NO_HEAP") != nullptr) {
        ::_exit(99);
      }
    }
  }
} report;

}  // namespace

// Deviation: the names are the linker's (--wrap).
extern "C" {
void* __real_malloc(std::size_t size);                                         // NOLINT
void* __real_calloc(std::size_t count, std::size_t size);                      // NOLINT
void* __real_realloc(void* memory, std::size_t size);                          // NOLINT
void* __real_aligned_alloc(std::size_t step, std::size_t size);                // NOLINT
int __real_posix_memalign(void** memory, std::size_t step, std::size_t size);  // NOLINT
int __real_ioctl(int descriptor, unsigned long request, void* answer);         // NOLINT

void* __wrap_malloc(std::size_t size) {  // NOLINT
  count();
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t number, std::size_t size) {  // NOLINT
  count();
  return __real_calloc(number, size);
}
void* __wrap_realloc(void* memory, std::size_t size) {  // NOLINT
  count();
  return __real_realloc(memory, size);
}
void* __wrap_aligned_alloc(std::size_t step, std::size_t size) {  // NOLINT
  count();
  return __real_aligned_alloc(step, size);
}
int __wrap_posix_memalign(void** memory, std::size_t step, std::size_t size) {  // NOLINT
  count();
  return __real_posix_memalign(memory, step, size);
}
int __wrap_ioctl(int descriptor, unsigned long request, void* answer) {  // NOLINT
  if (descriptor == STDIN_FILENO && request == FIONREAD && is_main_thread()) {
    at_last_tick = allocations;
    at_first_tick = ticks == 0 ? at_last_tick : at_first_tick;
    ++ticks;
  }
  return __real_ioctl(descriptor, request, answer);
}
}
