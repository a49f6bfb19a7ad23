// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string_view>

#include "host_tests/sim/world/pose_source.h"
#include "protocol/telemetry.h"

namespace m100::sim {

/// What a lie remembers: the first message that it struck, and what it keeps back or repeats.
template <typename Message>
struct LieMemory {
  std::optional<Message> first;
  std::deque<Message> kept;
  double t_s = 0.0;  ///< since the first one
};

/// A lie of one channel that a test or a script tells by name: every message is well formed, and wrong.
struct Lie {
  std::string_view name;
  std::string_view words;  ///< what is wrong, in a table
  double size = 0.0;       ///< of the lie as it is told without a number
  std::string_view unit;   ///< of its size; empty: it has none
  void (*pose)(PoseSample& sample, LieMemory<PoseSample>& memory, double size) = nullptr;
  void (*telemetry)(protocol::Telemetry& telemetry, LieMemory<protocol::Telemetry>& memory, double size) = nullptr;
};

std::span<const Lie> lies();
/// By its name; null: there is none.
const Lie* lie_of(std::string_view name);

/// Tells one lie from its first message on. Noise of what stands still comes from the digits of what it hides, so that
/// no two messages are the same bits and nothing is drawn at random.
class Liar {
 public:
  Liar(const Lie& lie, double size) : lie_(&lie), size_(size) {}
  explicit Liar(const Lie& lie) : Liar(lie, lie.size) {}
  void tell(PoseSample& sample);
  void tell(protocol::Telemetry& telemetry);

 private:
  const Lie* lie_;
  double size_;
  LieMemory<PoseSample> poses_;
  LieMemory<protocol::Telemetry> telemetry_;
};

}  // namespace m100::sim
