// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hal/uart.h"

namespace m100::sim {

/// The autopilot's end of a pseudo-terminal; a client opens the other end by the name of a symbolic link as if it were
/// a serial port. The line is raw before the client comes, so nothing is echoed or translated. Not paced: that is
/// N1Line's.
class PtyUart final : public hal::Uart {
 public:
  /// @throws std::runtime_error: no pseudo-terminal, or the link cannot be made. An existing symbolic link is replaced;
  /// anything else of that name is not.
  explicit PtyUart(std::string link);
  ~PtyUart();

  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;
  const std::string& link() const { return link_; }

 private:
  std::string link_;
  int master_ = -1;
  int slave_ = -1;  ///< kept open, so that a client who leaves does not hang up the line
};

}  // namespace m100::sim
