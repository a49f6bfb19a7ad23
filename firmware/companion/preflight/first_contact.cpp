// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/first_contact.h"

#include "firmware/companion/operator/text_line.h"

namespace m100::companion {
namespace {

using Stage = safety::AuthorityStage;

constexpr core::Duration kJudgedAfter = std::chrono::seconds(1);  ///< until rates and items show
constexpr double kOwnRate_hz = 75.0;                              ///< we ask for 100; the assistant's default is 50
constexpr std::uint32_t kAssumedRequests = 2;                     ///< protocol, 6.1

}  // namespace

void FirstContact::update(core::TimePoint now, const link::SerialLink& link) {
  const Stage stage = link.authority().stage;
  requests_ += stage == Stage::kObtaining && last_stage_ != Stage::kObtaining ? 1U : 0U;
  last_stage_ = stage;
  update_start(now, link);
  update_control(now, link);
}

void FirstContact::update_start(core::TimePoint now, const link::SerialLink& link) {
  const Stage stage = link.authority().stage;
  const bool is_starting =
      stage == Stage::kListening || stage == Stage::kRequestingVersion || stage == Stage::kActivating;
  streamed_before_activation_ = streamed_before_activation_ || (is_starting && link.health().packages > 0);
  const bool was_ready = ready_since_ != core::TimePoint{};
  if (stage == Stage::kReady && !was_ready) {
    ready_since_ = now;
    report(now, "telemetry.before_activation", streamed_before_activation_, true);
  }
  if (was_ready && !rate_reported_ && now - ready_since_ >= kJudgedAfter) {
    rate_reported_ = true;
    report(now, "telemetry.obeys_rates", link.health().telemetry_rate_hz >= kOwnRate_hz, true);
  }
}

void FirstContact::update_control(core::TimePoint now, const link::SerialLink& link) {
  const link::AuthorityView& view = link.authority();
  const bool controlled = controls_since_ != core::TimePoint{};
  if (view.in_control && !controlled) {
    controls_since_ = now;
    TextLine line;
    line.add("first contact: control.requests_to_obtain = ").add(static_cast<double>(requests_), 0);
    operator_log_.write(now, line.add(requests_ == kAssumedRequests ? ", as assumed" : "; assumed: 2").text());
    operator_log_.write(now, "first contact: leave F and return, to see control.lost_push");
  }
  if (view.in_control && controlled && !control_reported_ && now - controls_since_ >= kJudgedAfter) {
    control_reported_ = true;
    if (link.telemetry().control.virtual_rc_on()) {
      report(now, "virtual_rc.shown_in_rc_item", link.telemetry().rc.mode != protocol::kRcModeF, true);
    }
  }
  const bool is_lost = controlled && !view.in_control && view.stage != Stage::kReleasing;
  if (is_lost && !lost_reported_) {
    lost_reported_ = true;
    const bool by_push = view.reason == safety::AuthorityReason::kControlLost;
    if (by_push || view.reason == safety::AuthorityReason::kLeftModeF ||
        view.reason == safety::AuthorityReason::kTaken) {
      report(now, "control.lost_push", by_push, true);
    }
  }
}

void FirstContact::report(core::TimePoint now, std::string_view key, bool seen, bool assumed) {
  TextLine line;
  line.add("first contact: ").add(key).add(" = ").add(seen ? "true" : "false");
  operator_log_.write(now, line.add(seen == assumed ? ", as assumed"
                                    : assumed       ? "; assumed: true"
                                                    : "; assumed: false")
                               .text());
}

}  // namespace m100::companion
