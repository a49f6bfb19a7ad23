// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <optional>
#include <variant>

#include "protocol/mavlink/command_messages.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/mission_messages.h"

// What a ground station requests when it connects. QGroundControl's connection ends only when it has read at least one
// parameter and a list of mission items. There is one parameter, read-only, and all lists are empty.
namespace m100::companion {

/// A message to the ground station.
using Reply = std::variant<mavlink::CommandAck, mavlink::ParamValue, mavlink::MissionCount, mavlink::MissionAck>;

/// The parameter: the number of our system.
inline constexpr mavlink::ParamValue kSystemNumber{.param_value = 1.F,
                                                   .param_count = 1,
                                                   .param_index = 0,
                                                   .param_id = {'M', 'A', 'V', '_', 'S', 'Y', 'S', '_', 'I', 'D'},
                                                   .param_type = 9};  // MAV_PARAM_TYPE_REAL32

inline std::optional<Reply> answer_to(const mavlink::ParamRequestList& /*asked*/, mavlink::Address /*from*/) {
  return kSystemNumber;
}
/// @returns nullopt: there is no such parameter, for which MAVLink has no answer.
inline std::optional<Reply> answer_to(const mavlink::ParamRequestRead& asked, mavlink::Address /*from*/) {
  const bool exists = asked.param_index < 0 ? std::strncmp(asked.param_id.data(), kSystemNumber.param_id.data(),
                                                           asked.param_id.size()) == 0
                                            : asked.param_index == kSystemNumber.param_index;
  return exists ? std::optional<Reply>(kSystemNumber) : std::nullopt;
}
/// The list of each type (mission, fence, rally points) is empty.
inline std::optional<Reply> answer_to(const mavlink::MissionRequestList& asked, mavlink::Address from) {
  return mavlink::MissionCount{
      .count = 0, .target_system = from.system, .target_component = from.component, .mission_type = asked.mission_type};
}
/// A list or a part of one that the ground station announces, and its order to clear one, are unsupported.
template <typename Upload>
std::optional<Reply> answer_to(const Upload& upload, mavlink::Address from) {
  return mavlink::MissionAck{.target_system = from.system,
                             .target_component = from.component,
                             .type = 3,  // MAV_MISSION_UNSUPPORTED
                             .mission_type = upload.mission_type};
}

}  // namespace m100::companion
