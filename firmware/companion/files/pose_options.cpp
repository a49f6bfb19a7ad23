// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/pose_options.h"

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/flight_file.h"
#include "hal/linux/udp_port.h"

namespace m100::companion {
namespace {

/// System 0: nobody. Errors: FileError.
mavlink::Address set_points_sender(const PoseOptions& options) {
  if (options.set_points_from.empty()) {
    return {.system = 0, .component = 0};
  }
  const link::SenderChoice chosen = sender_of(options.set_points_from, "--set-points-from");
  if (chosen.component == 0) {
    throw FileError("--set-points-from: needs system and component, as 1:240");
  }
  return {.system = chosen.system, .component = chosen.component};
}

}  // namespace

void add_pose_options(const Subcommand& command, PoseOptions& options, bool any_baud) {
  command.add_option(
      "--pose-port", options.port,
      "where the pose comes from (MAVLink: ATT_POS_MOCAP, VISION_POSITION_ESTIMATE or ODOMETRY): a serial "
      "port; udp:PORT, which needs --mavlink-key; or udp:127.0.0.1:PORT, for unsigned poses of a program on "
      "this board, which needs --pose-from. Example: udp:14560");
  const Option baud =
      command.add_option("--pose-baud", options.baud, "baud rate of the pose port, if it is a serial port");
  any_baud ? baud.in_range(1200, 4000000) : baud.one_of({115200, 230400, 460800, 921600});
  command
      .add_option("--pose-from", options.from,
                  "whose poses are used, if several send on the line: SYS or SYS:COMP, MAVLink's system and component")
      .type_name("SYS[:COMP]");
  command
      .add_option("--set-points-from", options.set_points_from,
                  "whose unsigned goals and set points are flown, on udp:127.0.0.1:PORT only; default: nobody's")
      .type_name("SYS:COMP");
  command.add_flag(
      "--accept-clock", options.accept_clock,
      "a signer whose time stamps begin behind this machine's clock is accepted; its stamps must rise, and "
      "frames that were sent before stay refused");
  command.add_option(
      "--mavlink-key", options.key_file,
      "file with the key of the signatures (64 hexadecimal digits, readable by its owner only); frames that "
      "are not signed with it, or that were sent before, are refused");
}

std::string conflict_of(const PoseOptions& options) {
  const bool is_loopback = hal::loopback_port_of(options.port).has_value();
  const bool is_network = hal::is_udp(options.port) && !is_loopback;
  const bool is_signed = !options.key_file.empty();
  const bool has_set_points = !options.set_points_from.empty();
  try {
    (void)choice_of(options);
    (void)set_points_sender(options);
  } catch (const FileError& wrong) {
    return wrong.what();
  }
  if (is_network && !hal::udp_port_of(options.port)) {
    return "--pose-port: " + options.port +
           ": a UDP port is written udp:PORT, or udp:127.0.0.1:PORT for programs of this board, PORT from 1 to 65535";
  }
  if (is_network && !is_signed) {
    return "--pose-port: " + options.port +
           ": poses over a network must be signed; name the key with --mavlink-key, or take unsigned poses of this "
           "board alone, with udp:127.0.0.1:PORT and --pose-from";
  }
  if (is_loopback && !is_signed && options.from.empty()) {
    return "--pose-port: " + options.port + ": unsigned poses need --pose-from SYS[:COMP], the sender that you trust";
  }
  if (has_set_points && is_signed) {
    return "--set-points-from: is for unsigned set points; with --mavlink-key every holder of the key may send them";
  }
  if (has_set_points && !is_loopback) {
    return "--set-points-from: unsigned set points are taken at --pose-port udp:127.0.0.1:PORT only";
  }
  if (options.port.empty() && is_signed) {
    return "--mavlink-key: is the key of the pose port, and needs --pose-port";
  }
  return "";
}

std::vector<std::string> words_of(const PoseOptions& options) {
  std::vector<std::string> words{"--pose-port", options.port};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) {
      words.insert(words.end(), {option, value});
    }
  };
  add("--pose-baud", hal::is_udp(options.port) ? "" : std::to_string(options.baud));
  add("--pose-from", options.from);
  add("--set-points-from", options.set_points_from);
  add("--mavlink-key", options.key_file);
  if (options.accept_clock) {
    words.emplace_back("--accept-clock");
  }
  return words;
}

link::SenderChoice choice_of(const PoseOptions& options) {
  return options.from.empty() ? link::SenderChoice{} : sender_of(options.from, "--pose-from");
}

std::optional<mavlink::Address> unsigned_sender(const PoseOptions& options) {
  return options.key_file.empty() ? std::optional(set_points_sender(options)) : std::nullopt;
}

}  // namespace m100::companion
