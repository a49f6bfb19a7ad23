// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tuple>

#include "protocol/mavlink/command_messages.h"
#include "protocol/mavlink/mission_messages.h"
#include "protocol/mavlink/pose_messages.h"
#include "protocol/mavlink/state_messages.h"

namespace m100::mavlink {

/// All messages that we read or write.
using Messages = std::tuple<AttPosMocap, VisionPositionEstimate, Odometry, Timesync, SetPositionTargetLocalNed,
                            CommandLong, CommandAck, ParamRequestRead, ParamRequestList, ParamValue, MissionRequestList,
                            MissionCount, MissionWritePartialList, MissionClearAll, MissionAck, Heartbeat,
                            AttitudeQuaternion, LocalPositionNed, EstimatorStatus, BatteryStatus, StatusText>;

/// Calls use.template operator()<Message>() for each type in Messages.
template <typename Use>
constexpr void for_each_message(Use&& use) {
  [&use]<typename... Message>(std::type_identity<std::tuple<Message...>>) {
    (use.template operator()<Message>(), ...);
  }(std::type_identity<Messages>{});
}

}  // namespace m100::mavlink
