# SPDX-License-Identifier: BSD-3-Clause
# AES for machines without a Debian library of mbedTLS: aes.c and its helpers from Debian's source package, once
# linker/fetch_mbedtls has fetched it. Without it the cross builds have no target m100::aes, and the commands that
# need it are refused by name.
set(M100_MBEDTLS_SOURCE ${PROJECT_SOURCE_DIR}/build/mbedtls CACHE PATH "Unpacked mbedTLS 2.28 source")
if(EXISTS ${M100_MBEDTLS_SOURCE}/library/aes.c)
  add_library(m100_mbedcrypto STATIC ${M100_MBEDTLS_SOURCE}/library/aes.c ${M100_MBEDTLS_SOURCE}/library/platform_util.c)
  target_include_directories(m100_mbedcrypto SYSTEM PUBLIC $<BUILD_INTERFACE:${M100_MBEDTLS_SOURCE}/include>)
  target_compile_definitions(m100_mbedcrypto PUBLIC
    $<BUILD_INTERFACE:MBEDTLS_CONFIG_FILE="${CMAKE_CURRENT_LIST_DIR}/mbedtls_aes_config.h">)
  m100_hide_checkout(m100_mbedcrypto)
  set_target_properties(m100_mbedcrypto PROPERTIES EXPORT_NAME mbedcrypto)
  add_dependencies(installed_modules m100_mbedcrypto)
  install(TARGETS m100_mbedcrypto EXPORT m100Targets)
  set(M100_MBEDCRYPTO m100_mbedcrypto)
else()
  message(STATUS "No AES in this build: run linker/fetch_mbedtls first if encrypted frames are wanted")
  set(M100_MBEDCRYPTO "")
endif()
