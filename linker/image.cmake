# SPDX-License-Identifier: BSD-3-Clause
# Links, measures and checks an image for a bare board. Only the bare-metal build includes this file; the settings of the
# board come from its toolchain file.
foreach(name M100_BOARD M100_BOARD_SCRIPT M100_BOARD_HEADER M100_BOARD_BUDGET M100_BOARD_MAIN)
  if(NOT DEFINED ${name})
    message(FATAL_ERROR "The toolchain file ${CMAKE_TOOLCHAIN_FILE} does not set ${name}: see linker/PORTING.md")
  endif()
endforeach()

find_package(Python3 COMPONENTS Interpreter REQUIRED)
set(M100_LINKER_DIR ${CMAKE_CURRENT_LIST_DIR})
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${M100_BOARD_BUDGET})

file(STRINGS ${M100_BOARD_BUDGET} stack_line REGEX "^stack_bytes")
string(REGEX MATCH "[0-9]+" M100_STACK_BYTES "${stack_line}")

# m100_image(name SOURCES main.cpp DEPS m100::app [FLIGHT])
#
# Makes <name>.elf with start-up code and memory map. Each build prints its size by module. FLIGHT images are checked
# against the board's budget of flash, RAM and stack.
function(m100_image name)
  cmake_parse_arguments(arg "FLIGHT" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${arg_SOURCES} $<TARGET_OBJECTS:m100_startup>)
  target_link_libraries(${name} PRIVATE ${arg_DEPS} m100_numerics m100_warnings)
  target_compile_definitions(${name} PRIVATE M100_BOARD_HEADER="${M100_BOARD_HEADER}")
  m100_hide_checkout(${name})
  target_link_options(${name} PRIVATE -T ${M100_BOARD_SCRIPT}
    -Wl,--defsym=m100_stack_bytes=${M100_STACK_BYTES} -Wl,-Map=$<TARGET_FILE:${name}>.map -Wl,--no-warn-rwx-segments)
  set_target_properties(${name} PROPERTIES LINK_DEPENDS ${M100_BOARD_SCRIPT})
  if(arg_FLIGHT)
    add_custom_command(TARGET ${name} POST_BUILD VERBATIM
      COMMAND ${Python3_EXECUTABLE} ${M100_LINKER_DIR}/size_report.py $<TARGET_FILE:${name}>.map
              ${M100_BOARD_BUDGET}
      COMMAND ${Python3_EXECUTABLE} ${M100_LINKER_DIR}/stack_report.py $<TARGET_FILE:${name}> ${PROJECT_BINARY_DIR}
              ${M100_BOARD_BUDGET})
  endif()
endfunction()
