// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string_view>

#include "host_tests/sim/world/pose_source.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// The state of a sensor fault: the first message that it changed, and the messages that it delays or repeats.
template <typename Message>
struct SensorFaultState {
  std::optional<Message> first;
  std::deque<Message> kept;
  double t_s = 0.0;  ///< since the first one
};

/// A sensor fault: false data of one channel, which a test or a script selects by name. Every message is well formed,
/// but wrong.
struct SensorFault {
  std::string_view name;
  std::string_view words;  ///< description for a table
  double size = 0.0;       ///< default size
  std::string_view unit;   ///< unit of the size; empty: the sensor fault has no size
  void (*pose)(PoseSample& sample, SensorFaultState<PoseSample>& memory, double size) = nullptr;
  void (*telemetry)(protocol::Telemetry& telemetry, SensorFaultState<protocol::Telemetry>& memory,
                    double size) = nullptr;
  /// Sizes that occur in the field, for tests that draw them; equal: half to one and a half times the default.
  double smallest = 0.0;
  double largest = 0.0;
};

std::span<const SensorFault> sensor_faults();
/// Finds a sensor fault by its name; null: unknown.
const SensorFault* find_sensor_fault(std::string_view name);

/// Applies one sensor fault to all messages, from the first one. The noise of values that stand still is derived from
/// the digits of the true values, so that no two messages have the same bits and no random numbers are drawn.
class SensorFaultInjector {
 public:
  SensorFaultInjector(const SensorFault& fault, double size) : fault_(&fault), size_(size) {}
  explicit SensorFaultInjector(const SensorFault& fault) : SensorFaultInjector(fault, fault.size) {}
  void apply(PoseSample& sample);
  void apply(protocol::Telemetry& telemetry);

 private:
  const SensorFault* fault_;
  double size_;
  SensorFaultState<PoseSample> poses_;
  SensorFaultState<protocol::Telemetry> telemetry_;
};

}  // namespace m100::sim
