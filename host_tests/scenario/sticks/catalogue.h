// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "host_tests/scenario/sticks/bench.h"

namespace m100::sticks {

/// Where the program is when the fault strikes. The rungs of the ladder are reached by taking the pose away: 60 ms
/// later it coasts, at most 0.7 s later it levels, 1 s later it releases.
enum class Stage : std::uint8_t { kStarting, kAsking, kFlying, kCoasting, kLevel, kRelease, kReleasing };
inline constexpr std::size_t kStages = 7;
inline constexpr std::array<std::string_view, kStages> kStageNames{"starting", "asking",  "flying",   "coast",
                                                                   "level",    "release", "releasing"};
constexpr std::uint8_t bit(Stage stage) { return static_cast<std::uint8_t>(1U << static_cast<unsigned>(stage)); }
inline constexpr std::uint8_t kAnyStage = 0x7F;
inline constexpr std::uint8_t kInFlight = bit(Stage::kFlying) | bit(Stage::kCoasting) | bit(Stage::kLevel);

enum class Group : std::uint8_t { kLine, kAuthority, kPort, kProcess, kPose };
inline constexpr std::array<std::string_view, 5> kGroupNames{"line", "authority", "port", "process", "pose"};

/// What the fault leaves of the line. What no byte of ours can reach, we cannot give back: then the operator is told.
enum class Reach : std::uint8_t {
  kBoth,
  kDeaf,   ///< nothing intact reaches us
  kMute,   ///< nothing intact of ours reaches the autopilot, until the fault is healed
  kTaken,  ///< somebody else holds control until the fault is healed: nobody can give it to the transmitter
  kLate,   ///< everything arrives, but so late that no time limit can hold
};

/// One way for something to go wrong.
struct Fault {
  std::string_view name;
  Group group;
  void (*strike)(Bench& bench);
  std::uint8_t stages = kAnyStage;
  /// The transmitter has control so soon after the strike; 0: the flight may go on.
  double within_s = 0.0;
  Reach reach = Reach::kBoth;
  double heals_after_s = 0.0;  ///< 0: never
  void (*heal)(Bench& bench) = nullptr;
  void (*prepare)(Setup& setup) = nullptr;  ///< before the programs are started
  bool flies_on = false;                    ///< and the flight must go on: the fault is none of its business
  bool needs_mount = false;                 ///< left out where can_mount() says no
  bool ends_program = false;                ///< by itself: no exit code is asked for, and no life after it
  bool ends_alone = false;                  ///< and it must: without the operator's stop, with exit code 1
  bool takes_guard = false;  ///< the second process is gone: with a death of the first that would be two deaths
};

// What R15 allows. The ladder from a lost pose: 60 ms to coast, 0.7 s to level, 1 s to release, 1.0 s for the
// release (R15), and 0.04 s for the source's interval, its latency and the tick.
inline constexpr double kLadder_s = 2.80;
inline constexpr double kSilentLink_s =
    1.6;                                  // 0.5 s until the link counts as lost, 1.0 s (R15), its ticks and the line
inline constexpr double kChange_s = 1.0;  // R15: stop, authority or Virtual RC changing without us
inline constexpr double kDeath_s = 1.5;   // R15: death or hang

/// Every fault of the battery. One row is one fault at all its stages.
std::span<const Fault> catalogue();

// Its parts.
std::span<const Fault> line_faults();
std::span<const Fault> authority_faults();  ///< and those of the port
std::span<const Fault> process_faults();
std::span<const Fault> pose_faults();

}  // namespace m100::sticks
