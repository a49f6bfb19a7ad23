// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "hal/uart.h"

namespace m100::companion {

/// Gives a tick the bytes that it read in flight, and keeps what it writes.
class RecordedUart final : public hal::Uart {
 public:
  /// @param mute refuses every write, as the port of a dry run does.
  explicit RecordedUart(bool mute) : mute_(mute) {}
  void next(const std::vector<std::byte>& input) {
    input_ = &input;
    at_ = 0;
    written_.clear();
  }
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const std::size_t count = input_ == nullptr ? 0 : std::min(destination.size(), input_->size() - at_);
    for (std::size_t i = 0; i < count; ++i) {
      destination[i] = (*input_)[at_ + i];
    }
    at_ += count;
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override {
    if (mute_) {
      return core::Status::kUnavailable;
    }
    written_.insert(written_.end(), source.begin(), source.end());
    return source.size();
  }
  const std::vector<std::byte>& written() const { return written_; }

 private:
  bool mute_;
  const std::vector<std::byte>* input_ = nullptr;
  std::size_t at_ = 0;
  std::vector<std::byte> written_;
};

}  // namespace m100::companion
