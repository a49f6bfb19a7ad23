# SPDX-License-Identifier: BSD-3-Clause
# Arm's MPS2 board with the AN386 image (Cortex-M4F), as QEMU emulates it: memory and devices as in the AN500 image
# (mps2_an500.cmake), but another processor.
include(${CMAKE_CURRENT_LIST_DIR}/cortex_m4f.cmake)
set(M100_BOARD mps2)
set(M100_BOARD_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/mps2_an500.ld)
set(M100_BOARD_HEADER hal/cortex_m/mps2.h)
set(M100_BOARD_BUDGET ${CMAKE_CURRENT_LIST_DIR}/budget_m4f.txt)
set(M100_BOARD_SOURCES ${CMAKE_CURRENT_LIST_DIR}/../hal/cortex_m/mps2_vectors.cpp)
set(M100_BOARD_MAIN firmware/app/image/main_mps2.cpp)
set(M100_BOARD_EMULATOR qemu-system-arm -M mps2-an386 -icount shift=0 -display none -monitor none)
