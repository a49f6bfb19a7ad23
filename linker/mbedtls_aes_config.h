/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef M100_MBEDTLS_AES_CONFIG_H
#define M100_MBEDTLS_AES_CONFIG_H

/* mbedTLS, reduced to AES with its tables in flash. */
#define MBEDTLS_AES_C
#define MBEDTLS_AES_ROM_TABLES

#endif
