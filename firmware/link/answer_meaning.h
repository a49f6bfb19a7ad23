// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/safety/authority.h"
#include "protocol/acks.h"
#include "protocol/frame.h"

namespace m100::link {

/// True if the stage waits for the answer to this command.
bool is_question_of(safety::Stage stage, protocol::MessageId command);

/// What an acknowledgement of two bytes means to the authority table.
safety::AuthoritySign meaning_of(const protocol::AckMeaning& answer, protocol::MessageId command);

}  // namespace m100::link
