// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_acknowledgements.h"

namespace m100::sim {

N1Request request_of(const protocol::Command& command, protocol::MessageId id) {
  if (const auto* request = std::get_if<protocol::ControlRequest>(&command)) {
    return request->obtain ? N1Request::kObtainControl : N1Request::kReleaseControl;
  }
  for (const N1RequestName& word : kN1RequestNames) {
    if (word.id == id) {
      return word.request;
    }
  }
  return N1Request::kAny;
}

bool N1Acknowledgements::accept(const protocol::FrameHeader& header) {
  const protocol::AnswerSessions::Reception reception = sessions_.accept(header);
  if (reception.verdict == protocol::AnswerSessions::Verdict::kRepeat) {
    send(reception.bytes, request_in_session_[header.session]);
    return false;
  }
  return reception.verdict != protocol::AnswerSessions::Verdict::kIgnore;
}

void N1Acknowledgements::answer(const protocol::FrameHeader& to, std::span<const std::byte> value,
                                const protocol::Cipher* cipher, N1Request request) {
  const core::Expected<protocol::Outgoing> frame = sessions_.answer(to, value, cipher);
  if (frame) {
    request_in_session_[to.session] = request;
    send(frame->bytes, request);
  }
}

bool N1Acknowledgements::loses(N1Request request) {
  if (to_lose_ == 0 || (to_lose_of_ != N1Request::kAny && to_lose_of_ != request)) {
    return false;
  }
  --to_lose_;
  return true;
}

void N1Acknowledgements::send(std::span<const std::byte> frame, N1Request request) {
  if (loses(request)) {
    log_.emit("did", "lost_ack");
    return;
  }
  const int copies = to_double_ > 0 ? 2 : 1;
  to_double_ -= to_double_ > 0 ? 1 : 0;
  for (int copy = 0; copy < copies; ++copy) {
    if (const core::Duration delay = own_delay_ + delay_; delay > core::Duration{0}) {
      line_.send_later(frame, log_.now() + delay);
    } else {
      (void)line_.send(frame, log_.now());
    }
  }
}

}  // namespace m100::sim
