// SPDX-License-Identifier: BSD-3-Clause
// From reset to main(), on any Cortex-M with an FPU. The symbols named __* come from the board's linker script; the
// board's vector table names the handlers defined here.
#include <cstdint>

#include "hal/cortex_m/exceptions.h"
#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/stack_paint.h"

/// The program's main(), which C++ does not let a program call by its own name.
extern "C" int image_main() asm("main");

extern "C" {
extern std::uint32_t __stack_limit;
extern std::uint32_t __stack_top;
extern std::uint32_t __data_load;
extern std::uint32_t __data_start;
extern std::uint32_t __data_end;
extern std::uint32_t __bss_start;
extern std::uint32_t __bss_end;
extern std::uint32_t __harness_start;
extern std::uint32_t __harness_end;
using Constructor = void (*)();
extern Constructor __init_array_start;
extern Constructor __init_array_end;
}

namespace m100::hal {
namespace {

void fill(std::uint32_t* from, const std::uint32_t* to, std::uint32_t value) {
  for (volatile std::uint32_t* word = from; word != to; word = word + 1) {
    *word = value;
  }
}

void enable_fpu() {
  auto* const coprocessor_access = reinterpret_cast<volatile std::uint32_t*>(0xE000ED88U);
  *coprocessor_access = *coprocessor_access | (0xFU << 20U);
  asm volatile("dsb\n isb");
}

/// Makes the MPU forbid the 64 KiB below the stack, which lies lowest in RAM: not every bus faults there by itself.
void guard_stack() {
  constexpr std::uint32_t kNoAccessNoExecute64K = (1U << 28U) | (15U << 1U) | 1U;
  constexpr std::uint32_t kOnBesideTheDefaultMap = 0x5U;
  auto* const control = reinterpret_cast<volatile std::uint32_t*>(0xE000ED94U);
  auto* const number = reinterpret_cast<volatile std::uint32_t*>(0xE000ED98U);
  auto* const base = reinterpret_cast<volatile std::uint32_t*>(0xE000ED9CU);
  auto* const attributes = reinterpret_cast<volatile std::uint32_t*>(0xE000EDA0U);
  *number = 0;
  *base = reinterpret_cast<std::uint32_t>(&__stack_limit) - 0x10000U;
  *attributes = kNoAccessNoExecute64K;
  *control = kOnBesideTheDefaultMap;
  asm volatile("dsb\n isb");
}

}  // namespace

std::uint32_t deepest_stack_bytes() {
  const std::uint32_t* word = &__stack_limit;
  while (word != &__stack_top && *word == kStackPaint) {
    ++word;
  }
  return static_cast<std::uint32_t>((&__stack_top - word) * 4);
}

void fail_assertion(const char* file, int line) {
  print("assertion failed: ");
  print(file);
  print(":");
  print(std::int64_t{line});
  print("\n");
  exit_emulator(kExitOfAssertion);
}

std::uint32_t reserved_stack_bytes() { return static_cast<std::uint32_t>((&__stack_top - &__stack_limit) * 4); }

}  // namespace m100::hal

extern "C" {

/// The program begins here. The order matters: no floating point before the FPU is on, no static object before its
/// memory is initialised.
void Reset_Handler() {
  using namespace m100::hal;
  enable_fpu();
  guard_stack();
  std::uint32_t* stack_pointer = nullptr;
  asm volatile("mov %0, sp" : "=r"(stack_pointer));
  fill(&__stack_limit, stack_pointer, kStackPaint);
  const std::uint32_t* source = &__data_load;
  for (volatile std::uint32_t* word = &__data_start; word != &__data_end; word = word + 1) {
    *word = *source++;
  }
  fill(&__bss_start, &__bss_end, 0);
  fill(&__harness_start, &__harness_end, 0);
  for (const Constructor* constructor = &__init_array_start; constructor != &__init_array_end; ++constructor) {
    (*constructor)();
  }
  exit_emulator(image_main());
}

/// @param frame the processor's exception frame: r0 to r3, r12, lr, pc, xpsr; meaningless if the stack itself faulted.
[[noreturn, gnu::used]] void m100_unhandled(const std::uint32_t* frame) {
  using namespace m100::hal;
  std::uint32_t exception = 0;
  asm volatile("mrs %0, ipsr" : "=r"(exception));
  print("unhandled exception ");  // 3: HardFault; from 16 on: interrupts
  print(std::int64_t{exception});
  const bool readable = frame >= &__stack_limit && frame + 8 <= &__stack_top;
  if (readable) {
    print(" at ");
    print_hex(frame[6]);
    print(" called from ");
    print_hex(frame[5]);
  }
  print(", fault status ");
  print_hex(*reinterpret_cast<volatile std::uint32_t*>(0xE000ED28U));
  print(" ");
  print_hex(*reinterpret_cast<volatile std::uint32_t*>(0xE000ED2CU));
  print(" address ");
  print_hex(*reinterpret_cast<volatile std::uint32_t*>(0xE000ED38U));
  print("\n");
  exit_emulator(kExitOfFault);
}

/// Reports on an empty stack, because the old one may be the cause of the fault.
[[gnu::naked]] void Default_Handler() {
  asm volatile(
      "mov r0, sp\n"
      "ldr r1, =__stack_top\n"
      "mov sp, r1\n"
      "b m100_unhandled\n"
      ".ltorg");
}

// Functions that the C++ run time needs, for a program without a heap that never ends.
void* __dso_handle = nullptr;
int __aeabi_atexit(void*, void (*)(void*), void*) { return 0; }
[[noreturn]] void __cxa_pure_virtual() {
  m100::hal::print("pure virtual call\n");
  m100::hal::exit_emulator(m100::hal::kExitOfAbort);
}
[[noreturn]] void abort() {
  m100::hal::print("abort\n");
  m100::hal::exit_emulator(m100::hal::kExitOfAbort);
}

}  // extern "C"
