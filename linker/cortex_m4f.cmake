# SPDX-License-Identifier: BSD-3-Clause
# Bare metal, Cortex-M4F: its FPU computes float only; double uses the compiler's library. A board's own toolchain file
# includes this file and sets the variables of the board.
set(CMAKE_SYSTEM_PROCESSOR cortex-m4)
set(M100_PROCESSOR_FLAGS "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard")
include(${CMAKE_CURRENT_LIST_DIR}/cortex_m.cmake)
