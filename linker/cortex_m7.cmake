# SPDX-License-Identifier: BSD-3-Clause
# Bare metal, Cortex-M7 with a double-precision FPU. A board's own toolchain file includes this file and sets the variables
# of the board.
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(M100_PROCESSOR_FLAGS "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard")
include(${CMAKE_CURRENT_LIST_DIR}/cortex_m.cmake)
