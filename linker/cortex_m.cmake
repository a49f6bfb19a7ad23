# SPDX-License-Identifier: BSD-3-Clause
# Bare metal, any Cortex-M with an FPU. The file of the processor sets M100_PROCESSOR_FLAGS and includes this file.
# Without --specs=nosys.specs, because with its _sbrk a heap would link (promise R1).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# The call graph with each function's stack, beside every object file: linker/stack_report.py reads it.
set(m100_machine "${M100_PROCESSOR_FLAGS} -ffunction-sections -fdata-sections -fcallgraph-info=su -fstack-usage")
set(CMAKE_C_FLAGS_INIT "${m100_machine}")
set(CMAKE_CXX_FLAGS_INIT
    "${m100_machine} -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-use-cxa-atexit -fno-unwind-tables")
# The relocations stay in the file, not in the image: linker/stack_report.py tells addresses from numbers by them.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles -Wl,--gc-sections,--emit-relocs")
set(CMAKE_EXECUTABLE_SUFFIX_CXX .elf)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
