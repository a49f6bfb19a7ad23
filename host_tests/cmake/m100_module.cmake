# SPDX-License-Identifier: BSD-3-Clause
# The one function that makes every library, the one that makes every test program, and the flags both share.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)

# What decides the bits of a result (promise R6) is PUBLIC: every file that sees a core type must agree on it.
add_library(m100_numerics INTERFACE)
target_compile_features(m100_numerics INTERFACE cxx_std_20)
target_compile_options(m100_numerics INTERFACE -ffp-contract=off -fno-fast-math -fno-math-errno)
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
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)

if(M100_SANITIZE)
  # -O1: the flights of the test run are long, and -O0 hides nothing that -O1 shows.
  set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1")
  target_compile_options(m100_numerics INTERFACE
    $<BUILD_INTERFACE:-fsanitize=address,undefined> $<BUILD_INTERFACE:-fno-sanitize=vptr>
    $<BUILD_INTERFACE:-fno-sanitize-recover=all> $<BUILD_INTERFACE:-fno-omit-frame-pointer>)
  target_link_options(m100_numerics INTERFACE $<BUILD_INTERFACE:-fsanitize=address,undefined>)
endif()
if(M100_TIDY)
  set(CMAKE_CXX_CLANG_TIDY clang-tidy)
endif()
if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set(M100_ON_LINUX ON)
endif()

add_custom_target(installed_modules)  # what the installed package holds

# m100_module(est HEADERS a.h SOURCES a.cpp DEPS m100::core [HOST_ONLY])
#
# Makes library m100_<name>, alias m100::<name>. Without SOURCES it is header-only. HOST_ONLY libraries may use
# exceptions and are not installed; all others are compiled without exceptions and RTTI on every machine.
function(m100_module name)
  cmake_parse_arguments(arg "HOST_ONLY" "" "HEADERS;SOURCES;DEPS" ${ARGN})
  if(arg_SOURCES)
    add_library(m100_${name} STATIC ${arg_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(m100_${name} PRIVATE $<BUILD_INTERFACE:m100_warnings>)
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

# m100_tests(LABEL unit NAME est SOURCES a_test.cpp b_test.cpp DEPS m100::est [TIMEOUT 120] [NATIVE])
#
# Makes the program <label>_<name> and registers each of its GoogleTest cases with ctest under the label. In a cross
# build the whole program is one test, because each start of the emulator costs more than most cases; a program whose
# libraries this machine does not have is left out, by name, and so is one that is NATIVE: it asks the kernel for what
# qemu-user does not pass on.
function(m100_tests)
  cmake_parse_arguments(arg "NATIVE" "LABEL;NAME;TIMEOUT" "SOURCES;DEPS" ${ARGN})
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
  add_executable(${program} ${arg_SOURCES})
  target_link_libraries(${program} PRIVATE ${arg_DEPS} m100_numerics m100_warnings GTest::gtest_main)
  if(NOT TARGET tests_${arg_LABEL})
    add_custom_target(tests_${arg_LABEL})  # all programs of a label, for those who want to build no more
  endif()
  add_dependencies(tests_${arg_LABEL} ${program})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  if(CMAKE_CROSSCOMPILING)
    add_test(NAME ${arg_LABEL}.${arg_NAME} COMMAND ${program} --gtest_brief=1 WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${arg_LABEL}.${arg_NAME} PROPERTIES LABELS "${arg_LABEL};${arg_NAME}" TIMEOUT 600)
    return()
  endif()
  gtest_discover_tests(${program} TEST_PREFIX "${arg_LABEL}.${arg_NAME}." DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES
    DISCOVERY_TIMEOUT 60
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    TEST_LIST ${program}_cases
    PROPERTIES TIMEOUT ${arg_TIMEOUT} SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]")
  # Both labels: PROPERTIES above takes no lists, and would keep the first label only.
  set(labels ${CMAKE_CURRENT_BINARY_DIR}/${program}_labels.cmake)
  file(WRITE ${labels} "if(${program}_cases)\n  set_tests_properties(\${${program}_cases} PROPERTIES LABELS "
                       "\"${arg_LABEL};${arg_NAME}\")\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${labels})
endfunction()

# Installs what the modules exported, so that find_package(m100) works elsewhere (see host_tests/consumer).
function(m100_install_package)
  install(EXPORT m100Targets NAMESPACE m100:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/m100)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/m100Config.cmake
    "include(CMakeFindDependencyMacro)\nfind_dependency(Eigen3 3.4)\n"
    "include(\${CMAKE_CURRENT_LIST_DIR}/m100Targets.cmake)\n")
  write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/m100ConfigVersion.cmake COMPATIBILITY SameMajorVersion)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/m100Config.cmake ${CMAKE_CURRENT_BINARY_DIR}/m100ConfigVersion.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/m100)
endfunction()
