# SPDX-License-Identifier: BSD-3-Clause
# The Debian packages: cpack in a build folder makes one for each component, host_tests/package does it for all machines
# and tries each in a test root. `cmake --install` copies the same files except those with an absolute destination.

# m100_ship(COMPONENT arguments of install...): a part of a package. A file or folder with an absolute destination belongs
# to the machine's own places and is in the package only.
function(m100_ship component)
  list(FIND ARGN DESTINATION at)
  math(EXPR at "${at} + 1")
  list(GET ARGN ${at} destination)
  set(only_packed "")
  if(IS_ABSOLUTE ${destination})
    set(only_packed EXCLUDE_FROM_ALL)
  endif()
  install(${ARGN} COMPONENT ${component} ${only_packed})
endfunction()

# m100_compress(FILE OUT): FILE as OUT, compressed as Debian wants its pages: without a name and a time.
function(m100_compress file out)
  execute_process(COMMAND gzip -9nc ${file} OUTPUT_FILE ${out} COMMAND_ERROR_IS_FATAL ANY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
endfunction()

# m100_package(COMPONENT NAME SUMMARY DESCRIPTION [DEPENDS text] [RECOMMENDS text] [SHLIBDEPS]): declares a package and gives
# it what every Debian package has: copyright, changelog and, if there are any, lintian's overrides.
function(m100_package component)
  cmake_parse_arguments(arg SHLIBDEPS "NAME;SECTION;SUMMARY;DESCRIPTION;DEPENDS;RECOMMENDS" "" ${ARGN})
  set(texts ${PROJECT_SOURCE_DIR}/firmware/companion/package)
  set(made ${PROJECT_BINARY_DIR}/package/${arg_NAME})
  set(M100_PACKAGE ${arg_NAME})
  configure_file(${texts}/changelog.in ${made}/changelog @ONLY)
  m100_compress(${made}/changelog ${made}/changelog.gz)
  m100_ship(${component} FILES ${texts}/copyright ${made}/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${arg_NAME})
  if(EXISTS ${texts}/${arg_NAME}.lintian)
    m100_ship(${component} FILES ${texts}/${arg_NAME}.lintian DESTINATION /usr/share/lintian/overrides RENAME ${arg_NAME})
  endif()
  string(TOUPPER ${component} upper)
  set_property(GLOBAL APPEND PROPERTY M100_COMPONENTS ${component})
  set_property(GLOBAL APPEND PROPERTY M100_PACKAGE_SETTINGS
    "set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${arg_NAME})"
    "set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${arg_SECTION})"
    "set(CPACK_DEBIAN_${upper}_DESCRIPTION [[${arg_SUMMARY}\n${arg_DESCRIPTION}]])"
    "set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS [[${arg_DEPENDS}]])"
    "set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS [[${arg_RECOMMENDS}]])"
    "set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ${arg_SHLIBDEPS})")
endfunction()

# Configures cpack for the declared packages; after everything that installs.
function(m100_configure_packages)
  get_property(components GLOBAL PROPERTY M100_COMPONENTS)
  get_property(settings GLOBAL PROPERTY M100_PACKAGE_SETTINGS)
  list(JOIN settings "\n" settings)
  cmake_language(EVAL CODE "${settings}")
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_NAME m100)
  set(CPACK_PACKAGE_VENDOR "m100")
  set(CPACK_PACKAGE_CONTACT "the m100 maintainers <maintainers@m100.example.org>")
  set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_COMPONENTS_ALL ${components})
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_BOARD_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/firmware/companion/package/conffiles)
  set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
  set(machine_aarch64 arm64)
  set(machine_arm armhf)
  set(machine_x86_64 amd64)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${machine_${CMAKE_SYSTEM_PROCESSOR}})
  set(CPACK_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/CPackConfig.cmake)
  set(CPACK_SOURCE_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/CPackSourceConfig.cmake)
  set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
  include(CPack)
endfunction()
