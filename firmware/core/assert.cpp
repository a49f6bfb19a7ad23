// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/assert.h"

namespace m100::core {
namespace {

AssertionHandler handler_in_force = nullptr;

}  // namespace

AssertionHandler set_assertion_handler(AssertionHandler handler) {
  const AssertionHandler former = handler_in_force;
  handler_in_force = handler;
  return former;
}

void assertion_failed(const char* file, int line) {
  if (handler_in_force != nullptr) {
    handler_in_force(file, line);
  }
  __builtin_trap();
}

}  // namespace m100::core
