// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/answer_meaning.h"

#include "protocol/catalogue.h"

namespace m100::link {

using safety::AuthoritySign;
using safety::Stage;

bool is_question_of(Stage stage, protocol::MessageId command) {
  switch (stage) {
    case Stage::kAskingVersion:
    case Stage::kInControl:  // whether our bytes arrive
      return command == protocol::ids::kVersionQuery;
    case Stage::kActivating:
      return command == protocol::ids::kActivation;
    case Stage::kSettingRates:
      return command == protocol::ids::kTelemetryFrequency;
    case Stage::kObtaining:
      return command == protocol::ids::kControlRequest;
    default:
      return false;
  }
}

safety::AuthoritySign meaning_of(const protocol::AckMeaning& answer, protocol::MessageId command) {
  if (answer.code == protocol::kAckNotAuthorised) {
    return AuthoritySign::kNotActivated;  // not the answer to a wrong key, for which a retry is useless
  }
  // The answer to a request for control names what was done, which may be the opposite of the request.
  if (command == protocol::ids::kControlRequest && answer.code == protocol::control_ack::kReleased) {
    return AuthoritySign::kRefused;
  }
  switch (answer.verdict) {
    case protocol::AckVerdict::kDone:
      return AuthoritySign::kDone;
    case protocol::AckVerdict::kSendAgain:
      return AuthoritySign::kAgain;
    case protocol::AckVerdict::kRetry:
      return AuthoritySign::kRetry;
    case protocol::AckVerdict::kRefused:
      break;
  }
  return AuthoritySign::kRefused;
}

}  // namespace m100::link
