// SPDX-License-Identifier: BSD-3-Clause
#include "hal/cortex_m/semihosting.h"

#include <array>
#include <bit>

namespace m100::hal {
namespace {

enum class Operation : std::uint32_t {
  kOpen = 0x01,
  kClose = 0x02,
  kWriteZeroEnded = 0x04,
  kRead = 0x06,
  kCommandLine = 0x15,
  kExitExtended = 0x20,
};

std::int32_t call(Operation operation, const void* parameters) {
  register std::uint32_t r0 asm("r0") = static_cast<std::uint32_t>(operation);
  register const void* r1 asm("r1") = parameters;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<std::int32_t>(r0);
}

std::uint32_t address(const void* pointer) { return std::bit_cast<std::uint32_t>(pointer); }

}  // namespace

void exit_emulator(int code) {
  constexpr std::uint32_t kApplicationExit = 0x20026;
  const std::array<std::uint32_t, 2> parameters{kApplicationExit, static_cast<std::uint32_t>(code)};
  call(Operation::kExitExtended, parameters.data());
  for (;;) {
  }
}

void print(std::string_view text) {
  std::array<char, 64> piece{};
  while (!text.empty()) {
    const std::size_t count = text.copy(piece.data(), piece.size() - 1);
    piece[count] = '\0';
    call(Operation::kWriteZeroEnded, piece.data());
    text.remove_prefix(count);
  }
}

void print(std::int64_t number) {
  std::array<char, 21> digits{};
  std::size_t first = digits.size();
  const bool negative = number < 0;
  std::uint64_t rest = negative ? 0U - static_cast<std::uint64_t>(number) : static_cast<std::uint64_t>(number);
  do {
    digits[--first] = static_cast<char>('0' + static_cast<char>(rest % 10U));
    rest /= 10U;
  } while (rest != 0U);
  if (negative) {
    digits[--first] = '-';
  }
  print(std::string_view(digits.data() + first, digits.size() - first));
}

void print_hex(std::uint32_t number) {
  std::array<char, 10> digits{'0', 'x'};
  for (std::size_t i = 0; i < 8; ++i) {
    digits[2 + i] = "0123456789abcdef"[(number >> (28U - 4U * i)) & 0xFU];
  }
  print(std::string_view(digits.data(), digits.size()));
}

std::string_view argument(std::size_t n) {
  [[gnu::section(".harness.command_line")]] static std::array<char, 256> line;
  const std::array<std::uint32_t, 2> parameters{address(line.data()), static_cast<std::uint32_t>(line.size())};
  if (call(Operation::kCommandLine, parameters.data()) != 0) {
    return {};
  }
  std::string_view rest(line.data());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t blank = rest.find(' ');
    rest.remove_prefix(blank == std::string_view::npos ? rest.size() : blank + 1);
  }
  const std::string_view word = rest.substr(0, rest.find(' '));
  line[static_cast<std::size_t>(word.data() - line.data()) + word.size()] = '\0';  // so that it can name a file
  return word;
}

HostFile::HostFile(std::string_view path) : handle_(-1) {
  constexpr std::uint32_t kReadBinary = 1;
  const std::array<std::uint32_t, 3> parameters{address(path.data()), kReadBinary,
                                                static_cast<std::uint32_t>(path.size())};
  handle_ = call(Operation::kOpen, parameters.data());
}

HostFile::~HostFile() {
  if (is_open()) {
    call(Operation::kClose, &handle_);
  }
}

std::span<std::byte> HostFile::read(std::span<std::byte> destination) {
  const std::array<std::uint32_t, 3> parameters{static_cast<std::uint32_t>(handle_), address(destination.data()),
                                                static_cast<std::uint32_t>(destination.size())};
  const std::int32_t missing = call(Operation::kRead, parameters.data());
  return destination.first(destination.size() - static_cast<std::size_t>(missing));
}

}  // namespace m100::hal
