// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string_view>

#include "host_tests/sim/world/pose_source.h"
#include "protocol/telemetry.h"

namespace m100::sim {

/// The state of a lie: the first message that it changed, and the messages that it delays or repeats.
template <typename Message>
struct LieMemory {
  std::optional<Message> first;
  std::deque<Message> kept;
  double t_s = 0.0;  ///< since the first one
};

/// A lie: false data of one channel, which a test or a script selects by name. Every message is well formed, but wrong.
struct Lie {
  std::string_view name;
  std::string_view words;  ///< description for a table
  double size = 0.0;       ///< default size
  std::string_view unit;   ///< unit of the size; empty: the lie has no size
  void (*pose)(PoseSample& sample, LieMemory<PoseSample>& memory, double size) = nullptr;
  void (*telemetry)(protocol::Telemetry& telemetry, LieMemory<protocol::Telemetry>& memory, double size) = nullptr;
};

std::span<const Lie> lies();
/// Finds a lie by its name; null: unknown.
const Lie* lie_of(std::string_view name);

/// Applies one lie to all messages, from the first one. The noise of values that stand still is derived from the digits
/// of the true values, so that no two messages have the same bits and no random numbers are drawn.
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
