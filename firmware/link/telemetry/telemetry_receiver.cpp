// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/telemetry/telemetry_receiver.h"

#include <algorithm>
#include <bit>

#include "firmware/link/telemetry/telemetry_check.h"

namespace m100::link {
namespace {

core::Status decode(protocol::TelemetryLayout layout, std::span<const std::byte> package, protocol::Telemetry& out) {
  if (layout != protocol::TelemetryLayout::kFamily) {
    return protocol::decode_telemetry(package, out);
  }
  protocol::FamilyItems more;
  return protocol::decode_family_telemetry(package, out, more);
}

}  // namespace

TelemetryReceiver::Reception TelemetryReceiver::take(std::span<const std::byte> package, bool waited,
                                                     core::TimePoint last, core::TimePoint now, LinkMeter& meter) {
  const protocol::Telemetry former = telemetry_;
  Reception reception;
  if (decode(layout_, package, telemetry_) != core::Status::kOk) {
    ++meter.counters().bad_packages;
    return reception;
  }
  if (telemetry_.has(protocol::TelemetryItem::kTime)) {
    const std::uint32_t ticks = telemetry_.time.ticks;
    const TelemetryClock::Verdict verdict = clock_.update(ticks, last, now);
    reception.restarted = verdict.restarted;
    if (verdict.restarted) {
      meter.restart();
    }
    if (verdict.is_new && !waited) {
      meter.timed_package(now, static_cast<std::int64_t>(ticks) * TelemetryClock::kTick);
    }
    if (!verdict.is_new) {
      telemetry_ = former;
      ++meter.counters().old_packages;
      reception.is_old = true;
      return reception;
    }
  }
  meter.counters().refused_items += reject_non_finite(telemetry_, former);
  meter.package(now);
  reception.items = telemetry_.items;
  for (std::size_t item = 0; item < item_times_.size(); ++item) {
    if (((std::uint32_t{telemetry_.items} >> item) & 1U) != 0) {
      item_times_[item] = now;
    }
  }
  seen_items_ = static_cast<std::uint16_t>(seen_items_ | telemetry_.items);
  telemetry_.items = static_cast<std::uint16_t>(telemetry_.items | former.items);
  return reception;
}

void TelemetryReceiver::reset() {
  seen_items_ = 0;
  item_times_ = {};
  clock_.reset();
  layout_ = protocol::TelemetryLayout::kM100;
}

core::TimePoint TelemetryReceiver::received_at(protocol::TelemetryItem item) const {
  const auto index = static_cast<std::size_t>(std::countr_zero(static_cast<std::uint16_t>(item)));
  return item_times_[std::min(index, item_times_.size() - 1)];
}

}  // namespace m100::link
