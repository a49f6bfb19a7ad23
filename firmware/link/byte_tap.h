// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/time.h"

namespace m100::link {

/// Sees every byte that passes a link, for the flight log.
class ByteTap {
 public:
  ByteTap(const ByteTap&) = delete;
  ByteTap& operator=(const ByteTap&) = delete;
  virtual void received(std::span<const std::byte> bytes, core::TimePoint now) = 0;
  virtual void sent(std::span<const std::byte> bytes, core::TimePoint now) = 0;

 protected:
  ByteTap() = default;
  ~ByteTap() = default;
};

}  // namespace m100::link
