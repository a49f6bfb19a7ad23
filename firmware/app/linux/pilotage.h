// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/app/linux/fly.h"

namespace m100::app {

/// The operator's part: Enter takes control when all is ready, Enter again (or an interrupt) gives it back. An
/// interrupt while control is being asked for gives back whatever comes of it.
class Pilotage {
 public:
  Pilotage(const FlyOptions& options, FlightController<double>& controller)
      : options_(options), controller_(controller) {}

  /// After each tick. @returns false: over.
  bool tick(core::TimePoint now) {
    const AuthorityView& authority = controller_.link().authority();
    tell(now, authority);
    const bool in_control = authority.in_control;
    switch (phase_) {
      case Phase::kWaiting:
        if (authority.stage == safety::Stage::kReady && (options_.take_control || key_pressed())) {
          controller_.engage();
          phase_ = Phase::kEngaging;
        }
        return !stop_asked();
      case Phase::kEngaging:
        if (in_control) {
          phase_ = Phase::kFlying;
          flew_ = true;
          since_ = now;
        } else if (stop_asked()) {
          release(now);
        }
        return !is_refused(authority);
      case Phase::kFlying:
        if (!in_control) {
          return false;  // lost, or given back by the ladder
        }
        if (stop_asked() || key_pressed() || is_over(now)) {
          release(now);
        }
        return true;
      case Phase::kReleasing:
        if (controller_.supervisor().rung() == safety::Rung::kSilent) {
          controller_.release();  // once more: an answer that was on its way may have granted control meanwhile
        }
        given_back_ = given_back_ || authority.reason == safety::Reason::kReleased;
        return !given_back_ && now - since_ < kHandOver;
    }
    return false;
  }
  bool flew() const { return flew_; }
  bool given_back() const { return given_back_; }

 private:
  enum class Phase { kWaiting, kEngaging, kFlying, kReleasing };

  static constexpr core::Duration kHandOver = std::chrono::seconds(5);

  void release(core::TimePoint now) {
    controller_.release();
    phase_ = Phase::kReleasing;
    since_ = now;
  }
  bool is_over(core::TimePoint now) const {
    return options_.take_control && core::seconds<double>(now - since_) >= options_.hold_s;
  }
  static bool is_refused(const AuthorityView& authority) {
    const bool at_rest = authority.stage == safety::Stage::kReady || authority.stage == safety::Stage::kSilent ||
                         authority.stage == safety::Stage::kSilentCold;
    return at_rest && !safety::remedy(authority.reason).empty() && authority.reason != safety::Reason::kStarting;
  }
  void tell(core::TimePoint now, const AuthorityView& authority) {
    const std::string text = describe(authority);
    if (text != told_) {
      told_ = text;
      std::ostringstream line;
      line << core::seconds<double>(now.time_since_epoch()) << " s  " << text;
      say(line.str());
    }
  }

  const FlyOptions& options_;
  FlightController<double>& controller_;
  Phase phase_ = Phase::kWaiting;
  core::TimePoint since_{};
  bool flew_ = false;
  bool given_back_ = false;
  std::string told_;
};

}  // namespace m100::app
