// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/mavlink/streams.h"

#include <algorithm>
#include <array>

#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::host_tests::mavlink_streams {
namespace {

using namespace mavlink;

constexpr std::array<std::uint16_t, 12> kIds{0, 1, 2, 21, 42, 43, 76, 102, 111, 138, 256, 331};

Bytes repeated(std::span<const std::byte> period, std::size_t count) {
  Bytes stream;
  while (stream.size() < count) {
    append(stream, period);
  }
  stream.resize(count);
  return stream;
}

std::byte any_byte(std::mt19937& random) { return static_cast<std::byte>(random() & 0xFFU); }

std::byte telling_byte(std::mt19937& random) {
  constexpr std::array<std::uint8_t, 16> kAlphabet{0xFD, 0xFD, 0xFD, 0xFD, 0,    0,    0,    0,
                                                   0xFE, 1,    2,    9,    0x15, 0x2B, 0x4B, 0xFF};
  return static_cast<std::byte>(kAlphabet.at(random() % kAlphabet.size()));
}

/// A frame of version 2 or 1 with any payload. Its checksum is right.
Bytes any_frame(std::mt19937& random) {
  const MessageInfo& info = *find_message(kIds.at(random() % kIds.size()));
  const bool is_1 = random() % 4 == 0 && info.id < 256;
  const bool is_signed = !is_1 && random() % 3 == 0;
  const std::size_t payload = is_1 ? info.min_bytes : random() % 256;
  Bytes frame(is_1 ? kHeader1Bytes : kHeader2Bytes);
  for (std::byte& value : frame) {
    value = any_byte(random);
  }
  frame[0] = is_1 ? kStart1 : kStart2;
  frame[1] = static_cast<std::byte>(payload);
  if (is_1) {
    frame[5] = static_cast<std::byte>(info.id);
  } else {
    frame[2] = static_cast<std::byte>(is_signed ? kSignedFlag : 0);
    frame[7] = static_cast<std::byte>(info.id & 0xFFU);
    frame[8] = static_cast<std::byte>(info.id >> 8U);
    frame[9] = std::byte{0};
  }
  for (std::size_t i = 0; i < payload; ++i) {
    frame.push_back(random() % 3 == 0 ? telling_byte(random) : any_byte(random));
  }
  const std::byte extra{info.crc_extra};
  const std::uint16_t sum = checksum(std::span(&extra, 1), checksum(std::span(frame).subspan(1)));
  frame.push_back(static_cast<std::byte>(sum & 0xFFU));
  frame.push_back(static_cast<std::byte>(sum >> 8U));
  frame.resize(frame.size() + (is_signed ? kSignatureBytes : 0), std::byte{0x5A});
  return frame;
}

Bytes header(std::mt19937& random, std::size_t payload) {
  const std::uint16_t id = kIds.at(random() % kIds.size());
  return {kStart2,
          static_cast<std::byte>(payload),
          static_cast<std::byte>(random() % 2),
          any_byte(random),
          any_byte(random),
          any_byte(random),
          any_byte(random),
          static_cast<std::byte>(id & 0xFFU),
          static_cast<std::byte>(id >> 8U),
          std::byte{0}};
}

}  // namespace

void append(Bytes& to, std::span<const std::byte> bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

Bytes clean_poses(std::size_t count) {
  Bytes stream;
  for (std::uint32_t number = 1; stream.size() < count; ++number) {
    const float part = static_cast<float>(number % 1000) * 1e-3F;
    const AttPosMocap pose{.time_usec = std::uint64_t{10'000} * number,
                           .q = {0.9F, part, 0.1F, -0.2F},
                           .x = part,
                           .y = 2.F - part,
                           .z = -1.F - part};
    append(stream, encode(pose, {9, 1}, static_cast<std::uint8_t>(number)).bytes());
  }
  return stream;
}

Bytes start_bytes(std::size_t count, std::byte start) { return Bytes(count, start); }

Bytes densest_headers(std::size_t count) {
  constexpr std::array<std::uint8_t, 11> kPeriod{0xFD, 0xFD, 0, 0, 0, 0xFD, 0xFD, 0, 0, 0, 0};
  return repeated(std::as_bytes(std::span(kPeriod)), count);
}

Bytes pattern(std::mt19937& random, std::size_t count) {
  Bytes period(2 + random() % 23);
  std::generate(period.begin(), period.end(), [&random] { return telling_byte(random); });
  return repeated(period, count);
}

Bytes headers(std::mt19937& random, std::size_t count) {
  const std::size_t payload = random() % 256;
  const Bytes gap(random() % 9, random() % 2 == 0 ? kStart2 : std::byte{0});
  Bytes stream;
  while (stream.size() < count) {
    append(stream, header(random, random() % 4 == 0 ? random() % 256 : payload));
    append(stream, gap);
  }
  return stream;
}

Bytes frames_among_headers(std::mt19937& random, std::size_t count) {
  Bytes stream;
  while (stream.size() < count) {
    if (random() % 3 == 0) {
      append(stream, header(random, random() % 256));  // its claim covers the frames that follow
    }
    if (random() % 4 == 0) {
      append(stream, pattern(random, random() % 40));
    }
    append(stream, any_frame(random));
  }
  return stream;
}

Reference reference_parse(std::span<const std::byte> stream) {
  const auto number = [&stream](std::size_t at) { return std::to_integer<std::size_t>(stream[at]); };
  Reference found;
  for (std::size_t at = 0; at < stream.size(); ++at) {
    const bool is_2 = stream[at] == kStart2;
    const std::size_t header_bytes = is_2 ? kHeader2Bytes : kHeader1Bytes;
    if (!is_2 && stream[at] != kStart1) {
      continue;
    }
    if (stream.size() - at < header_bytes) {
      break;
    }
    const std::size_t id = is_2 ? number(at + 7) | (number(at + 8) << 8U) | (number(at + 9) << 16U) : number(at + 5);
    const MessageInfo* const info = find_message(static_cast<std::uint32_t>(id));
    const std::size_t summed = header_bytes + number(at + 1);
    if (info == nullptr || (is_2 && number(at + 2) > kSignedFlag) || (!is_2 && number(at + 1) != info->min_bytes)) {
      continue;
    }
    if (stream.size() - at < summed + kCrcBytes) {
      break;
    }
    const std::byte extra{info->crc_extra};
    const std::size_t sum = checksum(std::span(&extra, 1), checksum(stream.subspan(at + 1, summed - 1)));
    if (sum != (number(at + summed) | (number(at + summed + 1) << 8U))) {
      ++found.crc_errors;
      continue;
    }
    const std::size_t whole = summed + kCrcBytes + (is_2 && number(at + 2) == kSignedFlag ? kSignatureBytes : 0);
    if (stream.size() - at < whole) {
      break;
    }
    found.offsets.push_back(at);
    at += whole - 1;
  }
  return found;
}

}  // namespace m100::host_tests::mavlink_streams
