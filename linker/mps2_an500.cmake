# SPDX-License-Identifier: BSD-3-Clause
# Arm's MPS2 board with the AN500 image (Cortex-M7), as QEMU emulates it. Another board needs a file like this one, and
# a preset that names it (PORTING.md).
include(${CMAKE_CURRENT_LIST_DIR}/cortex_m7.cmake)
set(M100_BOARD mps2)                                              # images are called m100_<board>.elf
set(M100_BOARD_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/mps2_an500.ld)    # memory map
set(M100_BOARD_HEADER hal/cortex_m/mps2.h)                        # addresses, as namespace m100::hal::board
set(M100_BOARD_BUDGET ${CMAKE_CURRENT_LIST_DIR}/budget.txt)         # what the flight image may use
set(M100_BOARD_SOURCES ${CMAKE_CURRENT_LIST_DIR}/../hal/cortex_m/mps2_vectors.cpp)
set(M100_BOARD_MAIN firmware/app/image/main_mps2.cpp)             # the flight program
set(M100_BOARD_EMULATOR qemu-system-arm -M mps2-an500 -icount shift=0 -display none -monitor none)  # leave out if there is none
