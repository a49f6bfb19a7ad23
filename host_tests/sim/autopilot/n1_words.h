// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "host_tests/sim/autopilot/n1_script.h"

// The words of a script for the emulated autopilot, for its reader and for the reference page.
namespace m100::sim {

struct N1Word {
  std::string_view text;
  double value;
};
inline constexpr std::array kN1Modes{N1Word{"F", 'F'}, N1Word{"A", 'A'}, N1Word{"P", 'P'}};
inline constexpr std::array kN1Switches{N1Word{"on", 1.0}, N1Word{"off", 0.0}};
inline constexpr std::array kN1Tasks{N1Word{"on", 1.0}, N1Word{"off", 0.0}, N1Word{"stuck", 2.0},
                                     N1Word{"endless", 3.0}};
inline constexpr std::array kN1Takers{N1Word{"mobile", 'm'}, N1Word{"rc", 'r'}};

struct N1Form {
  std::string_view name;
  N1Happening what;
  std::span<const N1Word> words;  ///< empty: a number
  double low = 0.0;
  double high = 0.0;  ///< low == high and no words: the form takes no value
  bool whole = false;
};
inline constexpr std::array kN1Forms{
    N1Form{"mode", N1Happening::kMode, kN1Modes},
    N1Form{"rc", N1Happening::kRc, kN1Switches},
    N1Form{"take", N1Happening::kTake, kN1Takers},
    N1Form{"ioc", N1Happening::kIoc, kN1Switches},
    N1Form{"tasks", N1Happening::kTasks, kN1Tasks},
    N1Form{"pose", N1Happening::kPose, kN1Switches},
    N1Form{"end_task", N1Happening::kEndTask, {}},
    N1Form{"restart", N1Happening::kRestart, {}},
    N1Form{"end_virtual_rc", N1Happening::kEndVirtualRc, {}},
    N1Form{"silence", N1Happening::kSilence, {}, 0.0, 3600.0},
    N1Form{"lose_acks", N1Happening::kLoseAcks, {}, 0.0, 1e6, true},
    N1Form{"delay_acks", N1Happening::kDelayAcks, {}, 0.0, 60.0},
    N1Form{"double_acks", N1Happening::kDoubleAcks, {}, 0.0, 1e6, true},
    N1Form{"noise", N1Happening::kNoise, {}, 1.0, 2048.0, true},
    N1Form{"loss", N1Happening::kLoss, {}, 0.0, 1.0},
    N1Form{"activation", N1Happening::kActivation, {}, 0.0, 65535.0, true},
};

struct N1StickWord {
  std::string_view name;
  N1StickMove::Shape shape;
};
inline constexpr std::array kN1StickWords{
    N1StickWord{"stick", N1StickMove::Shape::kStep}, N1StickWord{"doublet", N1StickMove::Shape::kDoublet},
    N1StickWord{"3211", N1StickMove::Shape::k3211}, N1StickWord{"chirp", N1StickMove::Shape::kChirp}};
inline constexpr std::string_view kN1LieWord = "lie";
inline constexpr std::array<std::string_view, 4> kN1StickNames{"roll", "pitch", "throttle", "yaw"};

}  // namespace m100::sim
