// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/link/pose/pose_senders.h"
#include "protocol/mavlink/frame.h"

namespace m100::companion {

class Subcommand;

/// Where the pose comes from, as the operator gives it.
struct PoseOptions {
  std::string port;             ///< a serial port, "udp:PORT" or "udp:127.0.0.1:PORT"; empty: none
  std::uint32_t baud = 115200;  ///< of a serial port
  std::string key_file;         ///< of the signatures; empty: signatures are not required
  std::string from;             ///< "SYS" or "SYS:COMP": whose poses are used; empty: not chosen by this option
  std::string set_points_from;  ///< "SYS:COMP": whose unsigned set points count; empty: nobody's
  bool accept_clock = false;    ///< the first time stamp of a signer may be old
};

/// Adds the options, the same for every command. @param any_baud --pose-baud takes 1200 to 4 000 000; else the rates
/// that DJI supports
void add_pose_options(const Subcommand& command, PoseOptions& options, bool any_baud = false);

/// Why the options do not go together: one sentence that begins with the option; empty: they do. Unsigned frames come
/// over a network from this machine alone and from a sender that is named.
std::string conflict_of(const PoseOptions& options);

/// The options as words of a command that takes them, for the commands that one command prints for the next.
std::vector<std::string> words_of(const PoseOptions& options);

/// The chosen sender. Errors: FileError.
link::SenderChoice choice_of(const PoseOptions& options);
/// Whose unsigned goals and set points count; system 0, which no sender has: nobody's. @returns nullopt: there is a
/// key, and everything is signed. Errors: FileError.
std::optional<mavlink::Address> unsigned_sender(const PoseOptions& options);

}  // namespace m100::companion
