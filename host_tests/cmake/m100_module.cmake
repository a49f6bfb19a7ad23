# SPDX-License-Identifier: BSD-3-Clause
# The one function that makes every library, the one that makes every test program, and the flags both share.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(CheckCXXSourceCompiles)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)

# What decides the bits of a result (promise R6) is PUBLIC: every file that sees a core type must agree on it.
# Without -fno-math-errno std::sqrt links the C library's sqrt and errno into the image.
add_library(m100_numerics INTERFACE)
target_compile_features(m100_numerics INTERFACE cxx_std_20)
target_compile_options(m100_numerics INTERFACE -ffp-contract=off -fno-fast-math -fno-math-errno)
# GCC 12 joins a product and a sum in its vectoriser (vfmaddsub) in spite of -ffp-contract=off, wherever x86 has fused
# multiply-add, which changed a flight's bits. A package may be used with such flags, so it always asks for it.
check_cxx_source_compiles("#ifndef __FMA__\n#error\n#endif\nint main() {}" M100_X86_HAS_FMA)
target_compile_options(m100_numerics INTERFACE
  $<BUILD_INTERFACE:$<$<AND:$<BOOL:${M100_X86_HAS_FMA}>,$<CXX_COMPILER_ID:GNU>>:-fno-tree-vectorize>>
  $<INSTALL_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-fno-tree-vectorize>>)
target_compile_definitions(m100_numerics INTERFACE EIGEN_DONT_VECTORIZE EIGEN_NO_IO EIGEN_MPL2_ONLY
                                                   EIGEN_CACHEFRIENDLY_PRODUCT_THRESHOLD=64)
target_include_directories(m100_numerics INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                   $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/m100>)
target_link_libraries(m100_numerics INTERFACE Eigen3::Eigen)
if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
  # Capacities that a board with kilobytes has to cut; no result depends on them.
  target_compile_definitions(m100_numerics INTERFACE M100_SMALL_MEMORY)
endif()
install(TARGETS m100_numerics EXPORT m100Targets)

# Our own taste, for our own files only.
add_library(m100_warnings INTERFACE)
target_compile_options(m100_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wdouble-promotion -Wshadow -Wundef -Wcast-align
  -Wold-style-cast -Werror
  # Deviation: GCC 12 warns falsely about std::string operator+ (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # Deviation: for Clang double to long double is a promotion too, which the lab's exact solutions ask for in every line; that
  # float does not become double unseen is held by GCC, on every build.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-double-promotion>)

if(M100_SANITIZE)
  # Compiling takes most of the sanitized part of a run: -O0, but for what computes (m100_module, COMPUTES).
  set(CMAKE_CXX_FLAGS_DEBUG "-O0 -g1")
  target_compile_definitions(m100_numerics INTERFACE $<BUILD_INTERFACE:M100_SANITIZED>)  # GCC alone has a name for it
  target_compile_options(m100_numerics INTERFACE
    $<BUILD_INTERFACE:-fsanitize=address,undefined> $<BUILD_INTERFACE:-fno-sanitize=vptr>
    $<BUILD_INTERFACE:-fno-sanitize-recover=all> $<BUILD_INTERFACE:-fno-omit-frame-pointer>)
  target_link_options(m100_numerics INTERFACE $<BUILD_INTERFACE:-fsanitize=address,undefined>)
endif()
# Under sanitizers, what is not in the product goes without the undefined-behaviour checks of each single pointer: they
# nearly double the time to compile it, and the address sanitizer finds what they find. Linked behind m100_numerics, because
# the last option counts.
add_library(m100_pointers_unchecked INTERFACE)
if(M100_SANITIZE)
  target_compile_options(m100_pointers_unchecked INTERFACE
    -fno-sanitize=null,alignment,object-size,pointer-overflow,nonnull-attribute,returns-nonnull-attribute)
endif()
if(M100_COVERAGE)
  # -O0: a line that the optimiser joins with another is counted wrongly. Everything is counted, because headers are compiled
  # into the tests; threads of the companion count in the same places.
  set(CMAKE_CXX_FLAGS_DEBUG "-O0")
  target_compile_options(m100_numerics INTERFACE $<BUILD_INTERFACE:--coverage> $<BUILD_INTERFACE:-fprofile-update=atomic>)
  target_link_options(m100_numerics INTERFACE $<BUILD_INTERFACE:--coverage>)
endif()
if(M100_TIDY)
  set(CMAKE_CXX_CLANG_TIDY clang-tidy)
endif()
if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set(M100_ON_LINUX ON)
endif()

add_custom_target(installed_modules)  # the libraries and programs that `cmake --install` copies

# m100_hide_checkout(target): the folder of the checkout stands nowhere in what this target compiles, neither in the texts
# of M100_ASSERT nor in debug information, so a build is the same from every folder.
function(m100_hide_checkout target)
  target_compile_options(${target} PRIVATE -ffile-prefix-map=${PROJECT_BINARY_DIR}=build
                                           -ffile-prefix-map=${PROJECT_SOURCE_DIR}=.
                                           -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)  # the last that fits counts
endfunction()

set(M100_HOST_TESTS ${PROJECT_SOURCE_DIR}/host_tests)

# m100_leave_out(name because): says that this build has no library of that name, so that what stands on it is left out
# too, by name, instead of failing to link.
function(m100_leave_out name because)
  message(STATUS "${name} is left out: no ${because} for ${CMAKE_SYSTEM_PROCESSOR}")
  set_property(GLOBAL APPEND PROPERTY M100_LEFT_OUT m100::${name})
endfunction()

# m100_left_out(RESULT names...): the first of these libraries that was left out, or nothing.
function(m100_left_out result)
  get_property(left_out GLOBAL PROPERTY M100_LEFT_OUT)
  set(${result} "" PARENT_SCOPE)
  foreach(name IN LISTS ARGN)
    if(name IN_LIST left_out)
      set(${result} ${name} PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

# m100_smaller(-O2 files...)
#
# Where flash is short, these files of the library of this folder are compiled with that and not with -O3: what runs once
# in a flight or once in a while with -Os, what watches with -O2. The laws and the filters stay as they are.
function(m100_smaller level)
  if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${level}")
  endif()
endfunction()

# Where a preset asks for CMAKE_UNITY_BUILD, the files of a program or library are compiled joined, a dozen at a time: they
# parse the same headers and instantiate the same templates, which costs more than their own lines do. Results do not
# depend on it (-ffp-contract=off; the tests of the hashes hold it).
set(CMAKE_UNITY_BUILD_BATCH_SIZE 12)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${M100_HOST_TESTS}/cmake/compiled_alone.txt)
file(STRINGS ${M100_HOST_TESTS}/cmake/compiled_alone.txt M100_COMPILED_ALONE REGEX "^[^#]")

# m100_join(target): all but those of compiled_alone.txt, which must name files that exist.
function(m100_join target)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source NORMALIZE OUTPUT_VARIABLE file)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    if(file IN_LIST M100_COMPILED_ALONE)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()

# m100_module(est [SMALL] [COMPUTES] [COLD] HEADERS files... SOURCES files... DEPS m100::core [HOST_ONLY])
#
# Makes library m100_<name>, alias m100::<name>. Without SOURCES it is header-only. HOST_ONLY libraries may use
# exceptions and are not installed; all others are compiled without exceptions and RTTI on every machine. A library
# that stands on one that was left out is left out as well. A SMALL one is compiled for size where flash is short: what
# moves bytes and reads tables gains nothing from unrolled loops. One that COMPUTES for long in the tests is compiled with -O1
# under sanitizers, where all others are with -O0. A COLD one reads files and options, prints, or calls what takes time:
# -O1 takes a third off compiling it, and the programs are no slower.
function(m100_module name)
  cmake_parse_arguments(arg "HOST_ONLY;SMALL;COMPUTES;COLD" "" "HEADERS;SOURCES;DEPS" ${ARGN})
  m100_left_out(missing ${arg_DEPS})
  if(missing)
    m100_leave_out(${name} ${missing})
    return()
  endif()
  set(is_a_test OFF)
  if(arg_SOURCES)
    add_library(m100_${name} STATIC ${arg_SOURCES})
    m100_join(m100_${name})
    set(scope PUBLIC)
    target_link_libraries(m100_${name} PRIVATE $<BUILD_INTERFACE:m100_warnings>)
    cmake_path(IS_PREFIX M100_HOST_TESTS ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE is_a_test)
    if(NOT is_a_test)
      m100_hide_checkout(m100_${name})  # it may be in a program that ships
    endif()
    if(arg_SMALL AND CMAKE_SYSTEM_NAME STREQUAL "Generic")
      target_compile_options(m100_${name} PRIVATE -Os)
    endif()
    if((arg_COMPUTES AND M100_SANITIZE) OR (arg_COLD AND CMAKE_BUILD_TYPE STREQUAL "Release"))
      target_compile_options(m100_${name} PRIVATE -O1)
    endif()
    if(NOT arg_HOST_ONLY)
      target_compile_options(m100_${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-fno-exceptions -fno-rtti> -Wvla)
    endif()
  else()
    add_library(m100_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(m100::${name} ALIAS m100_${name})
  set_target_properties(m100_${name} PROPERTIES EXPORT_NAME ${name})
  target_link_libraries(m100_${name} ${scope} m100_numerics ${arg_DEPS})
  if(is_a_test)
    target_link_libraries(m100_${name} PRIVATE m100_pointers_unchecked)
  endif()
  if(arg_HEADERS)
    target_sources(m100_${name} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${arg_HEADERS})
  endif()
  if(NOT arg_HOST_ONLY)
    if(arg_SOURCES)
      add_dependencies(installed_modules m100_${name})
    endif()
    install(TARGETS m100_${name} EXPORT m100Targets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/m100)
  endif()
endfunction()

# Tests, and the reading of options, call what takes time and do not do it themselves: -O1 takes a third off compiling them.
# What they call stays optimised.
add_library(m100_compiled_soon INTERFACE)
target_compile_options(m100_compiled_soon INTERFACE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1>)
target_link_libraries(m100_compiled_soon INTERFACE m100_pointers_unchecked)

# m100_test_headers(target): the headers that nearly every test parses, precompiled once per build: they cost a test more
# than its own lines do.
function(m100_test_headers target)
  if(NOT TARGET m100_test_headers)
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/test_headers.cpp CONTENT "// Only its precompiled header is wanted.\n")
    add_library(m100_test_headers OBJECT ${PROJECT_BINARY_DIR}/test_headers.cpp)
    target_link_libraries(m100_test_headers PRIVATE m100::core m100_warnings m100_compiled_soon GTest::gtest)
    target_precompile_headers(m100_test_headers PRIVATE <gtest/gtest.h> <firmware/core/eigen.h> <fstream>)
  endif()
  target_precompile_headers(${target} REUSE_FROM m100_test_headers)
endfunction()

# What gives each test program a folder for its temporary files, compiled once per build.
function(m100_own_folder)
  if(TARGET m100_own_folder)
    return()
  endif()
  add_library(m100_own_folder OBJECT ${M100_HOST_TESTS}/own_folder.cpp)
  target_link_libraries(m100_own_folder PRIVATE m100::core m100_warnings)
endfunction()

# Flights in real time mostly wait, and are judged by what they waited for the processor. So they begin early and by twos,
# whatever the number of tests at once, and what computes has the other places. Each takes one of two lanes, in turn.
set(M100_IN_REAL_TIME_COST 30)

# m100_tests(LABEL unit NAME est SOURCES files... DEPS m100::est [TIMEOUT 1200] [NATIVE] [OPTIMISED] [COMPUTES] [REAL_TIME])
#
# Makes the program <label>_<name> and registers each of its GoogleTest cases with ctest under the label. In a cross
# build the whole program is one test, because each start of the emulator costs more than most cases; a program whose
# libraries this machine does not have is left out, by name, and so is one that is NATIVE: it asks the kernel for what
# qemu-user does not pass on. One that is OPTIMISED does much itself and is compiled with -O1 under sanitizers. One that
# COMPUTES for long has the label `computes` as well and stands in target
# tests_computing instead of tests_<label>: by day it runs optimised, under sanitizers at night. The cases of one in
# REAL_TIME take the lanes above.
function(m100_tests)
  cmake_parse_arguments(arg "NATIVE;OPTIMISED;COMPUTES;REAL_TIME" "LABEL;NAME;TIMEOUT" "SOURCES;DEPS" ${ARGN})
  set(program ${arg_LABEL}_${arg_NAME})
  if(CMAKE_CROSSCOMPILING)
    if(arg_NATIVE)
      message(STATUS "${program} is left out: it needs a kernel of its own")
      return()
    endif()
    foreach(dependency IN LISTS arg_DEPS)
      if(NOT TARGET ${dependency} AND NOT EXISTS ${dependency})
        message(STATUS "${program} is left out: no ${dependency} for ${CMAKE_SYSTEM_PROCESSOR}")
        return()
      endif()
    endforeach()
  endif()
  m100_own_folder()
  add_executable(${program} ${arg_SOURCES})
  m100_join(${program})
  target_link_libraries(${program} PRIVATE ${arg_DEPS} m100_own_folder m100::core m100_warnings m100_compiled_soon
    GTest::gtest_main)
  if(arg_OPTIMISED AND M100_SANITIZE)
    target_compile_options(${program} PRIVATE -O1)  # the precompiled headers are those of -O0
  else()
    m100_test_headers(${program})
  endif()
  if(CMAKE_CROSSCOMPILING)
    # Deviation: GCC 12 for ARM warns falsely about std::string operator+ where <string> comes precompiled; the PC's
    # build of the same files keeps the warnings.
    target_compile_options(${program} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
  endif()
  set(labels "${arg_LABEL};${arg_NAME}")
  set(all tests_${arg_LABEL})  # all programs of a label, for those who want to build no more
  if(arg_COMPUTES AND NOT CMAKE_CROSSCOMPILING)
    list(APPEND labels computes)
    set(all tests_computing)
  endif()
  if(NOT TARGET ${all})
    add_custom_target(${all})
  endif()
  add_dependencies(${all} ${program})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 1200)  # ends what hangs, on a machine as busy as may be; no test is judged by the time it takes
  endif()
  if(CMAKE_CROSSCOMPILING)
    add_test(NAME ${arg_LABEL}.${arg_NAME} COMMAND ${program} --gtest_brief=1 WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${arg_LABEL}.${arg_NAME} PROPERTIES LABELS "${labels}" TIMEOUT 3600)
    return()
  endif()
  gtest_discover_tests(${program} TEST_PREFIX "${arg_LABEL}.${arg_NAME}." DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES
    DISCOVERY_TIMEOUT 600
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    TEST_LIST ${program}_cases
    PROPERTIES TIMEOUT ${arg_TIMEOUT} SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]")
  # All labels: PROPERTIES above takes no lists, and would keep the first label only.
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${program}_labels.cmake)
  file(WRITE ${file} "if(${program}_cases)\n  set_tests_properties(\${${program}_cases} PROPERTIES LABELS "
                     "\"${labels}\")\nendif()\n")
  if(arg_REAL_TIME)
    file(APPEND ${file} "set(lane 0)\nforeach(case IN LISTS ${program}_cases)\n"
                        "  set_tests_properties(\${case} PROPERTIES RESOURCE_LOCK real_time_\${lane} COST ${M100_IN_REAL_TIME_COST})\n"
                        "  math(EXPR lane \"1 - \${lane}\")\nendforeach()\n")
  endif()
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

# `cmake --install` after a partial build names the target to build, before it copies anything. Call it before the first
# install rule.
function(m100_check_before_install)
  install(CODE "file(STRINGS \"${CMAKE_CURRENT_BINARY_DIR}/installed_files.txt\" files)
    foreach(file IN LISTS files)
      if(NOT EXISTS \"\${file}\")
        message(FATAL_ERROR \"\${file} is not built: run cmake --build ${CMAKE_BINARY_DIR} --target installed_modules\")
      endif()
    endforeach()")
endfunction()

# Installs what the modules exported, so that find_package(m100) works elsewhere (see host_tests/consumer).
function(m100_install_package)
  get_target_property(modules installed_modules MANUALLY_ADDED_DEPENDENCIES)
  list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_FILE:\\1>")
  list(JOIN modules "\n" files)
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/installed_files.txt CONTENT "${files}\n")
  install(EXPORT m100Targets NAMESPACE m100:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/m100)
  set(needs "find_dependency(Eigen3 3.4)\n")
  set(files ${CMAKE_CURRENT_BINARY_DIR}/m100Config.cmake ${CMAKE_CURRENT_BINARY_DIR}/m100ConfigVersion.cmake)
  if(TARGET MbedCrypto::mbedcrypto)
    string(APPEND needs "list(APPEND CMAKE_MODULE_PATH \${CMAKE_CURRENT_LIST_DIR})\nfind_dependency(MbedCrypto)\n"
                        "list(REMOVE_ITEM CMAKE_MODULE_PATH \${CMAKE_CURRENT_LIST_DIR})\n")
    list(APPEND files ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/FindMbedCrypto.cmake)
  endif()
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/m100Config.cmake
    "include(CMakeFindDependencyMacro)\n${needs}include(\${CMAKE_CURRENT_LIST_DIR}/m100Targets.cmake)\n")
  write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/m100ConfigVersion.cmake COMPATIBILITY SameMajorVersion)
  install(FILES ${files} DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/m100)
  m100_install_pkg_config()
endfunction()

# The same for those who use pkg-config: one package of all libraries, in a group because they refer to each other. Where it
# was moved to, pkg-config finds out by itself.
function(m100_install_pkg_config)
  get_target_property(modules installed_modules MANUALLY_ADDED_DEPENDENCIES)
  list(REMOVE_ITEM modules m100 m100-lab)
  list(REMOVE_ITEM modules m100_aes)  # needs mbedTLS, which has no .pc file everywhere
  list(TRANSFORM modules REPLACE "(.+)" "-l\\1")
  list(JOIN modules " " libraries)
  get_target_property(definitions m100_numerics INTERFACE_COMPILE_DEFINITIONS)
  list(TRANSFORM definitions PREPEND "-D")
  list(JOIN definitions " " definitions)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/m100.pc "prefix=\${pcfiledir}/../..
Name: m100
Description: ${PROJECT_DESCRIPTION}
Version: ${PROJECT_VERSION}
Requires: eigen3
Cflags: -I\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}/m100 ${definitions} -ffp-contract=off -fno-fast-math -fno-math-errno
Libs: -L\${prefix}/${CMAKE_INSTALL_LIBDIR} -Wl,--start-group ${libraries} -Wl,--end-group
")
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/m100.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
