// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/assert.h"

namespace m100::sysid {

/// The command of one transport delay ago, between two samples by interpolation.
template <typename Real>
class DelayedCommand {
 public:
  static constexpr std::size_t kCapacity = 64;  ///< most samples of delay, plus two

  /// Precondition (asserted): the delay fits into the ring; otherwise value() would return too new a command.
  DelayedCommand(Real delay_s, Real sample_period_s) : samples_(delay_s / sample_period_s) {
    M100_ASSERT(delay_s <= sample_period_s * static_cast<Real>(kCapacity - 2));
  }

  void add(Real command) {
    newest_ = (newest_ + 1) % kCapacity;
    commands_[newest_] = command;
  }

  Real value() const {
    const auto whole = static_cast<std::size_t>(samples_);
    const Real part = samples_ - static_cast<Real>(whole);
    const Real newer = commands_[(newest_ + kCapacity - whole) % kCapacity];
    const Real older = commands_[(newest_ + kCapacity - whole - 1) % kCapacity];
    return newer + part * (older - newer);
  }

 private:
  Real samples_;
  std::array<Real, kCapacity> commands_{};  ///< ring
  std::size_t newest_ = 0;
};

}  // namespace m100::sysid
