// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>

#include "firmware/companion/files/text/json.h"
#include "protocol/dji/frame.h"

namespace m100::lab {

/// A readable description of a message: its name and its values, with units in the keys.
struct Description {
  std::string name;
  Json fields = Json::object();
  bool malformed = false;  ///< the size or a code does not fit the message
};

/// @param answered the command that an acknowledgement answers, if it is known.
Description describe(const protocol::Message& message, const std::optional<protocol::MessageId>& answered);

/// Remembers the last command of each session, so that an acknowledgement in the same recording can be named.
class CommandMemory {
 public:
  void note(const protocol::Message& message);
  std::optional<protocol::MessageId> command_of(const protocol::FrameHeader& ack) const;

 private:
  struct Entry {
    std::uint16_t sequence = 0;
    protocol::MessageId id;
  };
  std::array<std::optional<Entry>, protocol::kSessionCount> last_;
};

/// One line of `m100-lab frames decode`.
Json frame_line(const protocol::FrameView& frame, const protocol::Cipher* cipher, CommandMemory& memory);

}  // namespace m100::lab
