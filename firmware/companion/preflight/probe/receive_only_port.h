// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/uart.h"

namespace m100::companion {

/// A port that only listens: it refuses every write.
class ReceiveOnlyPort final : public hal::Uart {
 public:
  explicit ReceiveOnlyPort(hal::Uart& port) : port_(port) {}
  core::Expected<std::size_t> read(std::span<std::byte> destination) override { return port_.read(destination); }
  core::Expected<std::size_t> write(std::span<const std::byte>) override { return core::Status::kUnavailable; }
  core::Expected<hal::LineErrors> line_errors() const override { return port_.line_errors(); }

 private:
  hal::Uart& port_;
};

}  // namespace m100::companion
