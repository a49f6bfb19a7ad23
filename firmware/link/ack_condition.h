// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/safety/authority.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame.h"

namespace m100::link {

/// True if the stage waits for the answer to this command.
bool awaits_ack_of(safety::AuthorityStage stage, protocol::MessageId command);

/// What an acknowledgement of two bytes means to the authority table.
safety::AuthorityCondition condition_of(const protocol::AckMeaning& answer, protocol::MessageId command);

}  // namespace m100::link
