// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "hal/uart.h"
#include "protocol/mavlink/parser.h"

namespace m100::companion {

/// A line that passes all bytes on, and calls receive() with each intact MAVLink frame. Costs one more parser. No heap.
class MavlinkTap : public hal::Uart {
 public:
  explicit MavlinkTap(hal::Uart& line) : line_(line) {}

  core::Expected<std::size_t> read(std::span<std::byte> destination) final {
    const core::Expected<std::size_t> count = line_.read(destination);
    if (count && *count > 0) {
      parser_.consume(std::span<const std::byte>(destination).first(*count),
                      [this](const mavlink::FrameView& frame) { receive(frame); });
    }
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) final { return line_.write(source); }
  core::Expected<hal::LineErrors> line_errors() const final { return line_.line_errors(); }

 protected:
  ~MavlinkTap() = default;
  virtual void receive(const mavlink::FrameView& frame) = 0;

 private:
  hal::Uart& line_;
  mavlink::Parser parser_;
};

}  // namespace m100::companion
