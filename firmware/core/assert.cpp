// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/assert.h"

namespace m100::core {
namespace {

AssertionHandler active_handler = nullptr;

}  // namespace

AssertionHandler set_assertion_handler(AssertionHandler handler) {
  const AssertionHandler former = active_handler;
  active_handler = handler;
  return former;
}

void assertion_failed(const char* file, int line) {
  if (active_handler != nullptr) {
    active_handler(file, line);
  }
  __builtin_trap();
}

}  // namespace m100::core
