// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/frame_receiver.h"

#include <algorithm>

#include "firmware/link/line_time.h"

namespace m100::link {

std::span<const std::byte> FrameReceiver::read(core::TimePoint now, LinkMeter& meter) {
  port_back_ = false;
  std::size_t used = 0;
  while (used < waiting_.size()) {
    const core::Expected<std::size_t> count = uart_.read(std::span(waiting_).subspan(used));
    if (!count) {
      meter.counters().outages += port_gone_ ? 0U : 1U;
      port_gone_ = true;
      break;
    }
    port_back_ = port_back_ || port_gone_;
    port_gone_ = false;
    if (*count == 0) {
      break;
    }
    if (tap_ != nullptr) {
      tap_->received(std::span(waiting_).subspan(used, *count), now);
    }
    used += *count;
  }
  meter.received(used);
  return std::span(waiting_).first(used);
}

core::TimePoint FrameReceiver::arrived(const protocol::FrameView& frame, core::TimePoint last,
                                       core::TimePoint now) const {
  const std::uint64_t behind = batch_end_ - (frame.offset + frame.bytes.size());
  return std::max(last, now - line_time(behind, baud_));
}

}  // namespace m100::link
