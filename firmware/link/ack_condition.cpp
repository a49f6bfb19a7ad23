// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/ack_condition.h"

#include "protocol/dji/catalogue.h"

namespace m100::link {

using safety::AuthorityCondition;
using safety::AuthorityStage;

bool awaits_ack_of(AuthorityStage stage, protocol::MessageId command) {
  switch (stage) {
    case AuthorityStage::kRequestingVersion:
    case AuthorityStage::kInControl:  // the query tests whether our bytes arrive
      return command == protocol::ids::kVersionQuery;
    case AuthorityStage::kActivating:
      return command == protocol::ids::kActivation;
    case AuthorityStage::kSettingRates:
      return command == protocol::ids::kTelemetryFrequency;
    case AuthorityStage::kObtaining:
      return command == protocol::ids::kControlRequest;
    default:
      return false;
  }
}

safety::AuthorityCondition condition_of(const protocol::AckMeaning& answer, protocol::MessageId command) {
  if (answer.code == protocol::kAckNotAuthorised) {
    return AuthorityCondition::kNotActivated;  // unlike the answer to a wrong key, after which a retry is useless
  }
  // The answer to a request for control names what was done, which may be the opposite of the request.
  if (command == protocol::ids::kControlRequest && answer.code == protocol::control_ack::kReleased) {
    return AuthorityCondition::kRefused;
  }
  switch (answer.verdict) {
    case protocol::AckVerdict::kDone:
      return AuthorityCondition::kDone;
    case protocol::AckVerdict::kSendAgain:
      return AuthorityCondition::kSendAgain;
    case protocol::AckVerdict::kRetry:
      return AuthorityCondition::kRetry;
    case protocol::AckVerdict::kRefused:
      break;
  }
  return AuthorityCondition::kRefused;
}

}  // namespace m100::link
