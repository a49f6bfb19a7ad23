// SPDX-License-Identifier: BSD-3-Clause
// Linked into the build of m100 that counts its lines (host_tests/coverage). A process that ends by exit() writes its
// counts there; the second process, which gives control back, ends by _exit(), so they are written before that.
extern "C" {
#include <gcov.h>  // a header for C only

[[noreturn]] void __real__exit(int code);   // NOLINT: the linker's names
[[noreturn]] void __wrap__exit(int code) {  // NOLINT
  __gcov_dump();
  __real__exit(code);
}
}
