// SPDX-License-Identifier: BSD-3-Clause
// The vector table of the MPS2 board: the handler of each interrupt. Another board needs a file like this one.
#include <array>
#include <cstdint>

// A program defines the handlers that it needs. The others jump to Default_Handler, with the stack unchanged.
#define M100_UNHANDLED(name) \
  [[gnu::weak, gnu::naked]] void name() { asm volatile("b Default_Handler"); }

extern "C" {
extern const std::uint32_t __stack_top;
void Reset_Handler();
void Default_Handler();

M100_UNHANDLED(NMI_Handler)
M100_UNHANDLED(SysTick_Handler)
M100_UNHANDLED(Uart0Rx_Handler)
M100_UNHANDLED(Uart0Tx_Handler)
M100_UNHANDLED(Uart1Rx_Handler)
M100_UNHANDLED(Uart1Tx_Handler)
M100_UNHANDLED(Uart2Rx_Handler)
M100_UNHANDLED(Uart2Tx_Handler)

struct VectorTable {
  const std::uint32_t* initial_stack;
  std::array<void (*)(), 15> system;      // reset, NMI, faults, ..., SysTick
  std::array<void (*)(), 16> interrupts;  // IRQ 0 ...
};

[[gnu::section(".vectors"), gnu::used]] const VectorTable vector_table{
    &__stack_top,
    {Reset_Handler, NMI_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, nullptr, nullptr,
     nullptr, nullptr, Default_Handler, Default_Handler, nullptr, Default_Handler, SysTick_Handler},
    {Uart0Rx_Handler, Uart0Tx_Handler, Uart1Rx_Handler, Uart1Tx_Handler, Uart2Rx_Handler, Uart2Tx_Handler,
     Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler,
     Default_Handler, Default_Handler, Default_Handler, Default_Handler}};
}
