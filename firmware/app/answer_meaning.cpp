// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/answer_meaning.h"

#include "protocol/catalogue.h"

namespace m100::app {

using safety::Fact;
using safety::Stage;

bool is_question_of(Stage stage, protocol::MessageId command) {
  switch (stage) {
    case Stage::kAskingVersion:
      return command == protocol::ids::kVersionQuery;
    case Stage::kActivating:
      return command == protocol::ids::kActivation;
    case Stage::kSettingRates:
      return command == protocol::ids::kTelemetryFrequency;
    case Stage::kObtaining:
    case Stage::kReleasing:
      return command == protocol::ids::kControlRequest;
    default:
      return false;
  }
}

safety::Fact meaning_of(const protocol::AckMeaning& answer, protocol::MessageId command, safety::Stage stage) {
  if (answer.code == protocol::kAckNotAuthorised || answer.code == protocol::kAckKeyError) {
    return Fact::kNotActivated;
  }
  // A request for control is answered by what was done, which may be the opposite of what was asked.
  const std::uint16_t opposite =
      stage == Stage::kReleasing ? protocol::control_ack::kObtained : protocol::control_ack::kReleased;
  if (command == protocol::ids::kControlRequest && answer.code == opposite) {
    return Fact::kRefused;
  }
  switch (answer.verdict) {
    case protocol::AckVerdict::kDone:
      return Fact::kDone;
    case protocol::AckVerdict::kSendAgain:
      return Fact::kAgain;
    case protocol::AckVerdict::kRetry:
      return Fact::kRetry;
    case protocol::AckVerdict::kRefused:
      break;
  }
  return Fact::kRefused;
}

}  // namespace m100::app
