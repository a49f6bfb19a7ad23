// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "protocol/cipher.h"

namespace m100::lab {

/// The origin of a line of input, for error messages.
struct LineOrigin {
  std::string file;
  long line = 0;
};

/// Reads a key of 64 hexadecimal digits. @throws InputError: it is anything else.
protocol::CipherKey parse_key(const std::string& hex, const LineOrigin& origin, const std::string& key_name);

/// The frame that a line of `m100-lab frames decode` (plus key_hex and padding_hex if encrypted) describes.
/// @param key for encrypted lines without a key_hex of their own.
/// @throws InputError naming file, line and key.
std::vector<std::byte> frame_from_line(const Json& line, const LineOrigin& origin,
                                       const std::optional<protocol::CipherKey>& key);

}  // namespace m100::lab
