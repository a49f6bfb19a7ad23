// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry points for frames. Random bytes never pass two checksums, so the mutator repairs them.
#include <cstddef>
#include <cstdint>
#include <random>

#include "host_tests/fuzz/receive.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  m100::host_tests::receive_everything(std::as_bytes(std::span(data, size)));
  return 0;
}

namespace {

/// Writes a start byte and a random length to a random place; repair_frames() then completes the header.
void plant_header(std::span<std::byte> bytes, std::mt19937& random) {
  constexpr std::size_t kHeaderBytes = 12;
  if (bytes.size() <= kHeaderBytes) {
    return;
  }
  const std::size_t at = random() % (bytes.size() - kHeaderBytes);
  const std::size_t room = bytes.size() - at;
  const std::size_t length = random() % 3 == 0 ? random() % 1024 : std::min<std::size_t>(room, 16 + random() % 64);
  bytes[at] = std::byte{0xAA};
  bytes[at + 1] = static_cast<std::byte>(length & 0xFFU);
  bytes[at + 2] = static_cast<std::byte>(length >> 8U);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  std::mt19937 random(seed);
  size = LLVMFuzzerMutate(data, size, max_size);
  if (size < 2) {
    return size;
  }
  const auto stream = std::as_writable_bytes(std::span(data, size)).subspan(1);  // byte 0 sets the size of the portions
  if (random() % 4 == 0) {
    plant_header(stream, random);
  }
  if (random() % 8 != 0) {
    m100::host_tests::repair_frames(stream, (std::uint64_t{random()} << 32U) | random());
  }
  return size;
}
