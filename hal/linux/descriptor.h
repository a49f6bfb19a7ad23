// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <utility>

namespace m100::hal {

/// Owns the descriptor of an open file or socket, and closes it. Below 0: there is none.
struct Descriptor {
  explicit Descriptor(int open = -1) : number(open) {}
  ~Descriptor() {
    if (number >= 0) {
      ::close(number);
    }
  }
  Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
  Descriptor& operator=(Descriptor other) noexcept {
    std::swap(number, other.number);
    return *this;
  }
  int number;
};

}  // namespace m100::hal
