// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/sha256.h"

#include <gtest/gtest.h>

#include <string>

namespace m100::core {
namespace {

std::string digest_of(const std::string& text, std::size_t piece) {
  Sha256 hash;
  for (std::size_t at = 0; at < text.size(); at += piece) {
    hash.update(std::as_bytes(std::span(text).subspan(at, std::min(piece, text.size() - at))));
  }
  const std::array<char, 64> digits = hex(hash.finish());
  return {digits.begin(), digits.end()};
}

struct KnownAnswer {
  const char* name;
  std::string text;
  const char* digest;
};

class Sha256Known : public ::testing::TestWithParam<KnownAnswer> {};

// The digests are published with FIPS 180-4. Feeding the bytes in pieces catches a lost carry between update() calls
// and wrong padding.
TEST_P(Sha256Known, GivesThePublishedDigestHoweverTheBytesAreCut) {
  for (const std::size_t piece : {1U, 3U, 55U, 64U, 1000U}) {
    EXPECT_EQ(digest_of(GetParam().text, piece), GetParam().digest) << "piece " << piece;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Fips, Sha256Known,
    ::testing::Values(KnownAnswer{"Empty", "", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
                      KnownAnswer{"Abc", "abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
                      KnownAnswer{"TwoBlocks", "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
                                  "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
                      KnownAnswer{"MillionA", std::string(1000000, 'a'),
                                  "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::core
