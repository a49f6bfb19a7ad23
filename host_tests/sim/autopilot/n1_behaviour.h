// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "firmware/core/time.h"

namespace m100::sim {

inline core::Duration duration_of_seconds(double value_s) { return core::Duration{std::llround(value_s * 1e6)}; }

/// What DJI's documents leave open about the autopilot, as the emulation assumes it. `m100-lab autopilot --real`
/// replaces an assumption by what was seen on the aircraft; firmware/companion/guide/FIRST_CONTACT.md says how to see
/// it.
struct N1Behaviour {
  struct Answers {
    double delay_s = 0.0;            ///< from a command to its acknowledgement
    bool needs_activation = true;    ///< commands of set 01 are refused before it
    bool wrong_key_in_plain = true;  ///< a command with a wrong key is answered, in plain
  };
  struct Control {
    double requests_to_obtain = 2.0;
    double requests_to_release = 2.0;
    bool lost_push = true;             ///< its loss is also sent as a push
    bool returns_with_mode_f = false;  ///< to the computer that had it, when the switch is back at F
  };
  struct VirtualRc {
    double timeout_s = 1.0;  ///< without data
    bool needs_control = false;
    bool end_gives_control_back = false;
    bool leaving_f_ends_it = true;
    bool shown_in_rc_item = true;       ///< its channels replace the transmitter's in telemetry
    bool data_under_switch_id = false;  ///< takes 64 bytes under the id of the switch, as SDK 3.3 to 4.1 send them
    double full_deflection_counts = 660.0;
    double roll_sign = 1.0, pitch_sign = 1.0, throttle_sign = 1.0, yaw_sign = 1.0;
  };
  struct Movement {
    double timeout_s = 0.5;  ///< then the aircraft holds its attitude
    bool timeout_gives_control_back = false;
    double roll_sign = 1.0, pitch_sign = 1.0, climb_sign = 1.0, yaw_sign = 1.0;
  };
  struct Tasks {
    bool offered = true;
    bool end_with_control = true;  ///< a task in progress ends when control is given back or lost
    double take_off_height_m = 1.2;
    double take_off_climb_m_s = 0.8;
    double landing_sink_m_s = 0.5;
  };
  struct Telemetry {
    bool before_activation = true;
    double rate_hz = 50.0;  ///< of most items, until a client sets the rates: 1, 10, 50 or 100
    bool obeys_rates = true;
    double acceleration_unit_m_s2 = 9.8066;
    double silent_after_restart_s = 2.0;
  };

  Answers answers{};
  Control control{};
  VirtualRc virtual_rc{};
  Movement movement{};
  Tasks tasks{};
  Telemetry telemetry{};
};

}  // namespace m100::sim
