// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "host_tests/sim/autopilot/n1_script.h"

// The words of a script for the emulated autopilot, for its reader and for the reference page.
namespace m100::sim {

struct N1NamedValue {
  std::string_view text;
  double value;
};
inline constexpr std::array kN1Modes{N1NamedValue{"F", 'F'}, N1NamedValue{"A", 'A'}, N1NamedValue{"P", 'P'}};
inline constexpr std::array kN1Switches{N1NamedValue{"on", 1.0}, N1NamedValue{"off", 0.0}};
inline constexpr std::array kN1Tasks{N1NamedValue{"on", 1.0}, N1NamedValue{"off", 0.0}, N1NamedValue{"stuck", 2.0},
                                     N1NamedValue{"endless", 3.0}};
inline constexpr std::array kN1Holders{N1NamedValue{"mobile", 'm'}, N1NamedValue{"rc", 'r'}};

struct N1EventSyntax {
  std::string_view name;
  N1EventKind what;
  std::span<const N1NamedValue> words;  ///< empty: a number
  double low = 0.0;
  double high = 0.0;  ///< low == high and no words: the form takes no value
  bool whole = false;
};
inline constexpr std::array kN1Events{
    N1EventSyntax{"mode", N1EventKind::kMode, kN1Modes},
    N1EventSyntax{"rc", N1EventKind::kRc, kN1Switches},
    N1EventSyntax{"take", N1EventKind::kTake, kN1Holders},
    N1EventSyntax{"ioc", N1EventKind::kIoc, kN1Switches},
    N1EventSyntax{"tasks", N1EventKind::kTasks, kN1Tasks},
    N1EventSyntax{"pose", N1EventKind::kPose, kN1Switches},
    N1EventSyntax{"end_task", N1EventKind::kEndTask, {}},
    N1EventSyntax{"restart", N1EventKind::kRestart, {}},
    N1EventSyntax{"end_virtual_rc", N1EventKind::kEndVirtualRc, {}},
    N1EventSyntax{"silence", N1EventKind::kSilence, {}, 0.0, 3600.0},
    N1EventSyntax{"lose_acks", N1EventKind::kLoseAcks, {}, 0.0, 1e6, true},
    N1EventSyntax{"delay_acks", N1EventKind::kDelayAcks, {}, 0.0, 60.0},
    N1EventSyntax{"double_acks", N1EventKind::kDoubleAcks, {}, 0.0, 1e6, true},
    N1EventSyntax{"noise", N1EventKind::kNoise, {}, 1.0, 2048.0, true},
    N1EventSyntax{"loss", N1EventKind::kLoss, {}, 0.0, 1.0},
    N1EventSyntax{"activation", N1EventKind::kActivation, {}, 0.0, 65535.0, true},
};

struct N1StickShapeName {
  std::string_view name;
  N1StickMove::Shape shape;
};
inline constexpr std::array kN1StickShapes{
    N1StickShapeName{"stick", N1StickMove::Shape::kStep}, N1StickShapeName{"doublet", N1StickMove::Shape::kDoublet},
    N1StickShapeName{"3211", N1StickMove::Shape::k3211}, N1StickShapeName{"chirp", N1StickMove::Shape::kChirp}};
inline constexpr std::string_view kN1FaultWord = "fault";
inline constexpr std::string_view kN1FaultWordBefore = "lie";  ///< of older scripts; still read
inline constexpr std::array<std::string_view, 4> kN1StickNames{"roll", "pitch", "throttle", "yaw"};

}  // namespace m100::sim
