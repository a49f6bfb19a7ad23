// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "host_tests/scenario/authority/bench.h"

namespace m100::authority {

/// The program's stage when the fault strikes. The states of the failsafe are reached by taking the pose away: the
/// program coasts 60 ms later, levels at most 0.7 s after that, and releases 1 s after that.
enum class Stage : std::uint8_t { kStarting, kAsking, kFlying, kCoasting, kLevel, kRelease, kReleasing };
inline constexpr std::size_t kStages = 7;
inline constexpr std::array<std::string_view, kStages> kStageNames{"starting", "asking",  "flying",   "coast",
                                                                   "level",    "release", "releasing"};
constexpr std::uint8_t bit(Stage stage) { return static_cast<std::uint8_t>(1U << static_cast<unsigned>(stage)); }
inline constexpr std::uint8_t kAnyStage = 0x7F;
inline constexpr std::uint8_t kInFlight = bit(Stage::kFlying) | bit(Stage::kCoasting) | bit(Stage::kLevel);

enum class Group : std::uint8_t { kLine, kAuthority, kPort, kProcess, kPose };
inline constexpr std::array<std::string_view, 5> kGroupNames{"line", "authority", "port", "process", "pose"};

/// What the fault leaves of the line. If no byte of ours arrives, control cannot be given back; the operator is told.
enum class FaultReach : std::uint8_t {
  kBoth,
  kDeaf,   ///< nothing intact reaches us
  kMute,   ///< nothing intact of ours reaches the autopilot, until the fault is healed
  kTaken,  ///< another device holds control until the fault is healed, and nobody can give it to the transmitter
  kLate,   ///< everything arrives, but so late that no time limit can hold
};

/// One fault of the battery.
struct Fault {
  std::string_view name;
  Group group{};  ///< set by of_group()
  void (*strike)(Bench& bench);
  std::uint8_t stages = kAnyStage;
  /// Limit from the strike until the transmitter has control; 0: the flight may continue.
  double within_s = 0.0;
  FaultReach reach = FaultReach::kBoth;
  double heals_after_s = 0.0;  ///< 0: never
  void (*heal)(Bench& bench) = nullptr;
  void (*prepare)(Setup& setup) = nullptr;  ///< before the programs are started
  bool flies_on = false;                    ///< the flight must continue
  bool needs_mount = false;                 ///< left out if can_mount() is false
  bool ends_program = false;  ///< the program ends by itself; its exit code and the time after it are not judged
  bool ends_alone = false;    ///< the program must end without the operator's stop, with exit code 1
  bool kills_backup = false;  ///< ends the second process, so a death of the first would be a double fault
};

// What R15 allows. The failsafe from a lost pose: 60 ms to coast, 0.7 s to level, 1 s to release, 1.0 s for the
// release (R15), and 0.04 s for the source's interval, its latency and the tick.
inline constexpr double kFailsafe_s = 2.80;
inline constexpr double kSilentLink_s =
    1.6;                                  // 0.5 s until the link counts as lost, 1.0 s (R15), its ticks and the line
inline constexpr double kChange_s = 1.0;  // R15: stop, authority or Virtual RC changing without us
inline constexpr double kDeath_s = 1.5;   // R15: death or hang

/// The rows of one group, which need not repeat it.
template <std::size_t kCount>
constexpr std::array<Fault, kCount> of_group(Group group, std::array<Fault, kCount> rows) {
  for (Fault& fault : rows) {
    fault.group = group;
  }
  return rows;
}

/// All faults of the battery; each row is one fault at all its stages.
std::span<const Fault> catalogue();

// Parts of the catalogue.
std::span<const Fault> line_faults();
std::span<const Fault> authority_faults();
std::span<const Fault> port_faults();
std::span<const Fault> process_faults();
std::span<const Fault> pose_faults();

}  // namespace m100::authority
