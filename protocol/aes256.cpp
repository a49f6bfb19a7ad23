// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/aes256.h"

#include <mbedtls/aes.h>

#include <new>

#include "firmware/core/assert.h"

namespace m100::protocol {
namespace {

mbedtls_aes_context* context(std::array<std::byte, 320>& bytes) {
  static_assert(sizeof(mbedtls_aes_context) <= sizeof(bytes) &&
                alignof(mbedtls_aes_context) <= alignof(std::max_align_t));
  return std::launder(static_cast<mbedtls_aes_context*>(static_cast<void*>(bytes.data())));
}

void run(mbedtls_aes_context* with, int mode, CipherBlock block) {
  auto* bytes = reinterpret_cast<unsigned char*>(block.data());
  // Fails for a wrong mode alone; the bytes would leave in plain.
  M100_ASSERT(mbedtls_aes_crypt_ecb(with, mode, bytes, bytes) == 0);
}

}  // namespace

Aes256::Aes256(const CipherKey& key) {
  mbedtls_aes_context* const encryption = new (encryption_.bytes.data()) mbedtls_aes_context;
  mbedtls_aes_context* const decryption = new (decryption_.bytes.data()) mbedtls_aes_context;
  mbedtls_aes_init(encryption);
  mbedtls_aes_init(decryption);
  // Fails for a wrong key length alone.
  M100_ASSERT(mbedtls_aes_setkey_enc(encryption, key.data(), 256) == 0);
  M100_ASSERT(mbedtls_aes_setkey_dec(decryption, key.data(), 256) == 0);
}

void Aes256::encrypt(CipherBlock block) const { run(context(encryption_.bytes), MBEDTLS_AES_ENCRYPT, block); }

void Aes256::decrypt(CipherBlock block) const { run(context(decryption_.bytes), MBEDTLS_AES_DECRYPT, block); }

}  // namespace m100::protocol
