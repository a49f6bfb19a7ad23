// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/safety/authority.h"
#include "protocol/acks.h"
#include "protocol/frame.h"

namespace m100::app {

/// True if the stage waits for the answer to this command.
bool is_question_of(safety::Stage stage, protocol::MessageId command);

/// What an acknowledgement of two bytes means to the authority table.
safety::Fact meaning_of(const protocol::AckMeaning& answer, protocol::MessageId command, safety::Stage stage);

}  // namespace m100::app
