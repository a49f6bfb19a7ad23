// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace m100::hal {

// Calls to the host that runs the emulator (Arm semihosting 2.0). Test images, the start of the MPS2 image, reports of
// a failure and the exit use them; a board without a debugger stops at the first one.

/// Ends the emulation; the emulator's exit status is `code`.
[[noreturn]] void exit_emulator(int code);

/// Writes to the emulator's standard error output.
void print(std::string_view text);
void print(std::int64_t number);
void print_hex(std::uint32_t number);

/// The n-th word (from 0) of the emulator's command line (-semihosting-config arg=...); empty if there is none. It
/// views a buffer that lives as long as the program.
std::string_view argument(std::size_t n);

/// A file of the host, read from its beginning.
class HostFile {
 public:
  /// @param path must be followed by a zero byte, as a literal is.
  explicit HostFile(std::string_view path);
  ~HostFile();
  HostFile(const HostFile&) = delete;
  HostFile& operator=(const HostFile&) = delete;

  bool is_open() const { return handle_ >= 0; }
  /// @returns the filled front of destination; shorter than destination at the end of the file.
  std::span<std::byte> read(std::span<std::byte> destination);

 private:
  std::int32_t handle_;
};

}  // namespace m100::hal
